#pragma once

#include <optional>
#include <vector>

#include "drivers/scsi/scsi_device.h"
#include "drivers/usb/usb_transport.h"

namespace reseau {

// SCSI commands in Nikon's USB wrapper: CDB, phase query D0, phase byte, data, status block.
// Never sends the optional status request 06: an LS-40 stops answering after it.
// Source: LS-5000 interface specification, USB; LS-50 firmware 1.02.
//
// The one place that retries: a command whose exchange broke (timeout, stall, answer of the wrong
// size) is followed by a resynchronisation of the pipe, and is sent again at most twice if a second
// sending does no harm; before the last attempt the USB side of the unit is reset. Thread-bound;
// borrows both arguments for its life.
class NikonUsbScsi final : public ScsiDevice {
 public:
  NikonUsbScsi(UsbTransport& usb, Clock& clock);

  [[nodiscard]] ScsiReply command(const Cdb& cdb, Duration timeout) override;
  [[nodiscard]] ScsiReply send(const Cdb& cdb, ByteView out, Duration timeout) override;
  [[nodiscard]] ScsiReply receive(const Cdb& cdb, std::span<std::byte> in,
                                  Duration timeout) override;
  void annotate(std::string_view phase) override { usb_.annotate(phase); }
  void resynchronise() override;

 private:
  struct CommandLost {};  // answered "busy", then nothing: the unit never took the command

  ScsiReply transact(const Cdb& cdb, ByteView out, std::span<std::byte> in, Duration timeout);
  ScsiReply transact_once(const Cdb& cdb, ByteView out, std::span<std::byte> in, TimePoint until);
  std::uint8_t query_phase(const Cdb& cdb, TimePoint until);
  // What came of a data phase. Less than asked for only when the unit says so in its status.
  struct DataPhase {
    std::size_t received = 0;
    std::optional<ScsiReply> status;  // it came in place of the rest of the data
  };
  DataPhase read_data(const Cdb& cdb, std::span<std::byte> in, TimePoint until);
  ScsiReply read_status(const Cdb& cdb, TimePoint until);
  void reset();
  [[nodiscard]] Duration remaining(TimePoint until) const;
  [[nodiscard]] bool full_speed() const { return max_packet_bytes_ < 512; }

  UsbTransport& usb_;
  Clock& clock_;
  std::size_t max_packet_bytes_;
  Duration query_delay_;
  std::vector<std::byte> packet_;   // one max packet: phase and status
  std::vector<std::byte> staging_;  // whole packets of a data phase
};

}  // namespace reseau
