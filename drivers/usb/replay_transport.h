#pragma once

#include <deque>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "drivers/usb/capture_reader.h"
#include "drivers/usb/recorded_device.h"
#include "drivers/usb/session_header.h"
#include "drivers/usb/usb_descriptors.h"
#include "drivers/usb/usb_transport.h"
#include "drivers/virtual_clock.h"

namespace reseau {

// Plays the bulk and vendor control transfers of one device back from a capture, in strict order:
// OUT bytes must be the recorded ones, IN transfers must ask for the recorded length where the
// capture says it. Recorded failures are thrown again. The first difference ends the replay: it and
// every later call throw a DeviceError that shows packet number, phase and both sides.
// Thread-bound; borrows the clock, which it moves to the recorded times.
class ReplayTransport final : public UsbTransport {
 public:
  // What a person wants to know of a command when the replay differs. Either may be empty.
  struct Decoder {
    std::function<std::string(ByteView cdb)> name;
    std::function<std::string(ByteView cdb)> source;  // where its form is described
    // The same for the six bytes of a command that came through the ports of a bridge.
    std::function<std::string(ByteView cdb)> bridge_name, bridge_source;
  };
  // Throws InputError for a file without commands, std::system_error when it cannot be opened.
  ReplayTransport(const std::filesystem::path& path, VirtualClock& clock, Decoder decode);
  // Called before each transfer is answered with the time that it ended at, counted from the first.
  void set_pace(std::function<void(Duration)> pace) { pace_ = std::move(pace); }

  // Plays from the last command again, for a program that has to repeat it.
  void to_last_command();

  [[nodiscard]] const SessionHeader& header() const { return header_; }
  [[nodiscard]] const UsbIdentity& identity() const override { return device_.identity; }
  void bulk_out(Endpoint endpoint, std::span<const std::byte> data, Duration timeout) override;
  std::size_t bulk_in(Endpoint endpoint, std::span<std::byte> buffer, Duration timeout) override;
  void control_out(const ControlRequest& request, std::span<const std::byte> data,
                   Duration timeout) override;
  std::size_t control_in(const ControlRequest& request, std::span<std::byte> buffer,
                         Duration timeout) override;
  void clear_halt(Endpoint endpoint) override;
  void reset() override;

 private:
  [[nodiscard]] std::optional<UsbTransfer> next_of_device();
  void find_first_command();
  void take_flight(UsbTransfer& first, std::size_t wanted);
  // The transfer that comes next; throws at the end of the recording.
  UsbTransfer take(const std::string& asked);
  void control(const UsbSetup& setup, const std::string& asked);
  void finish(const UsbTransfer& transfer, std::size_t asked_bytes);
  // `sent`: what is OUT now, where the first different byte is to be named.
  [[noreturn]] void differ(const UsbTransfer& recorded, const std::string& asked,
                           ByteView sent = {});
  [[noreturn]] void end(DeviceError error);
  // The command of a bridge that a transfer belongs to, read on in the recording where it is new.
  [[nodiscard]] std::string bridge_command_text(const UsbTransfer& recorded);
  [[nodiscard]] std::string describe(const UsbTransfer& transfer) const;
  [[nodiscard]] std::string describe_out(ByteView data) const;

  std::filesystem::path path_;
  RecordedDevice device_;
  TransferReader transfers_;
  VirtualClock& clock_;
  Decoder decode_;
  SessionHeader header_;
  std::deque<UsbTransfer> ahead_;   // read already, still to be played
  std::vector<UsbTransfer> taken_;  // played since the last command, that one included
  std::optional<DeviceError> ended_;
  std::int64_t start_us_ = 0;
  TimePoint clock_start_;
  std::string phase_;
  Bytes command_;  // the last one that was the same on both sides
  Bytes bridge_;   // what the command port was sent since it was opened
  long n_transfers_ = 0;
  std::function<void(Duration)> pace_;
};

}  // namespace reseau
