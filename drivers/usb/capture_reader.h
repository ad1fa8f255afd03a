#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "drivers/usb/usb_capture.h"

namespace reseau {

// Reads pcapng and classic pcap files of USB traffic, block by block, so that the size of a file
// does not matter. Blocks and packets of other kinds are passed over; a last block that was cut off
// ends the file. Thread-bound.
class CaptureReader {
 public:
  // Throws std::system_error when the file cannot be opened, InputError when it is no capture.
  explicit CaptureReader(const std::filesystem::path& path);

  // Absent at the end. Throws InputError for a file that is broken in the middle.
  [[nodiscard]] std::optional<UsbPacket> next();
  // Of the first section header; empty when there is none.
  [[nodiscard]] const std::string& comment() const { return comment_; }

 private:
  struct Interface {
    int link_type = 0;
    std::uint64_t ticks_per_second = 1'000'000;
  };
  struct Options {
    std::string comment;
    std::uint64_t ticks_per_second = 0;
  };

  [[nodiscard]] std::optional<UsbPacket> next_as_written();
  [[nodiscard]] std::optional<UsbPacket> next_classic();
  void append_what_follows(UsbPacket& packet);
  [[nodiscard]] bool seen_elsewhere(const UsbPacket& packet, std::size_t interface_index);
  [[nodiscard]] std::optional<UsbPacket> packet_of_block(std::uint32_t type, ByteView body);
  void section_header(ByteView body);
  void interface(ByteView body);
  [[nodiscard]] Options options(ByteView bytes) const;
  [[nodiscard]] std::uint64_t number(ByteView bytes, std::size_t offset, std::size_t n) const;
  // Fills the buffer with n bytes of the file; false when fewer are left.
  bool read(std::size_t n);
  void step_back(std::size_t n);
  [[noreturn]] void broken(const std::string& what) const;

  std::filesystem::path path_;
  std::ifstream file_;
  std::uint64_t left_bytes_ = 0;
  Bytes buffer_;
  std::string comment_;
  std::vector<Interface> interfaces_;  // classic: the only one
  // Whose packets are taken from which interface: "all buses" repeats those of a single bus.
  std::map<std::uint32_t, std::size_t> interface_of_;
  std::deque<UsbPacket> ahead_;
  bool classic_ = false;
  bool big_endian_ = false;
  std::uint64_t n_packets_ = 0;
};

// Pairs submissions with completions; transfers come in the order in which they were submitted.
class TransferReader {
 public:
  explicit TransferReader(const std::filesystem::path& path) : packets_(path) {}
  // Absent at the end; a transfer without a completion is left out.
  [[nodiscard]] std::optional<UsbTransfer> next();
  [[nodiscard]] const std::string& comment() const { return packets_.comment(); }

 private:
  struct Pending {
    UsbTransfer transfer;
    std::uint64_t id = 0;
    bool complete = false;
  };
  void complete(const UsbPacket& packet);

  CaptureReader packets_;
  std::deque<Pending> pending_;
};

}  // namespace reseau
