// A recording as commands: what a person or a test wants to read, instead of transfers.
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "drivers/bytes.h"
#include "drivers/usb/capture_reader.h"
#include "drivers/usb/recorded_device.h"
#include "drivers/usb/session_header.h"

namespace reseau {

// One command of Nikon's wrapper or of a PIE bridge with everything that belonged to it, or one
// control transfer.
struct Exchange {
  enum class Kind { kCommand, kBridge, kControl };
  Kind kind = Kind::kCommand;
  int number = 0;                  // from 1, over the recording
  std::uint64_t first_packet = 0;  // as Wireshark counts
  std::uint64_t last_packet = 0;
  std::int64_t started_us = 0;  // since 1970
  std::int64_t ended_us = 0;
  std::string phase;  // that the recording named last
  Bytes command;      // CDB; of a control transfer its setup packet
  std::optional<int> wrapper_phase;
  int n_phase_queries = 0;
  Bytes out;                   // data to the unit
  Bytes in;                    // data from it: the first kKeptBytes
  std::uint64_t in_bytes = 0;  // that came, or that the capture says came
  bool cut = false;            // the capture did not keep all that was moved
  Bytes status;  // 8 bytes, of a bridge 1: its port's last answer; empty when the capture has none
  int transfer_status = 0;  // 0 or the errno of the first transfer that failed, negative
  static constexpr std::size_t kKeptBytes = 4096;
  // Of Nikon's wrapper: the status block, and what the unit answers to a phase query.
  static constexpr std::size_t kStatusBytes = 8;
  static constexpr std::size_t kBridgeCdbBytes = 6;
  static constexpr std::uint8_t kBridgeCheck = 0x02;  // status: there is something to say
  static constexpr int kPhaseStatus = 1, kPhaseOut = 2, kPhaseIn = 3;
};

// Groups the transfers of one device. Thread-bound.
class ExchangeReader {
 public:
  // Throws as find_recorded_device() does.
  explicit ExchangeReader(const std::filesystem::path& path);

  [[nodiscard]] const SessionHeader& header() const { return header_; }
  [[nodiscard]] const RecordedDevice& device() const { return device_; }
  // Absent at the end. Throws InputError for a file that is broken in the middle.
  [[nodiscard]] std::optional<Exchange> next();
  // Transfers of the scanner that belong to no command: a capture that began in the middle.
  [[nodiscard]] int n_stray_transfers() const { return n_stray_; }

 private:
  [[nodiscard]] std::optional<UsbTransfer> next_transfer();
  void add(Exchange& exchange, const UsbTransfer& transfer);
  // Takes the standard's own requests out of the command that they came in between, to come after.
  [[nodiscard]] bool set_aside(UsbTransfer& transfer);
  void take_bridge_command(Exchange& exchange, UsbTransfer transfer);
  static void settle(Exchange& exchange, std::vector<Bytes>& ins);

  RecordedDevice device_;
  TransferReader transfers_;
  SessionHeader header_;
  std::deque<UsbTransfer> aside_;
  std::optional<UsbTransfer> ahead_;
  std::vector<Bytes> ins_;  // of the command that is being read
  bool exchange_open_ = false;
  bool asked_phase_ = false;
  std::int32_t taken_back_ = 0;  // how transfers of this command ended that were taken back
  std::string phase_;
  int n_exchanges_ = 0;
  int n_stray_ = 0;
};

}  // namespace reseau
