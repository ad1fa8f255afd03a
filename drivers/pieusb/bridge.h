#pragma once

#include <cstdint>
#include <vector>

#include "drivers/scsi/scsi_device.h"
#include "drivers/usb/usb_transport.h"

namespace reseau::pieusb {

// What the bridge says of a command (port 84).
enum class PortStatus : std::uint8_t {
  kGood = 0x00,
  kDataReady = 0x01,
  kCheck = 0x02,
  kBusy = 0x03,
  kAgain = 0x08,
};

// SCSI-like commands through the ports of the USB bridge: one byte per vendor request out, bulk
// data in (drivers/pieusb/README.md, *Protocol*).
//
// The one place that retries: a command that a failed transfer kept from reaching the unit is sent
// again, and so is one that does no harm when it comes twice; at most three times. Sense is fetched
// once per check condition. A READ that was begun is read to its end even when part of its data got
// lost; then `received` is below what was asked for. Never resets bridge or device, never sends
// what why_never() names: such a command is a DeviceError (kRefused) before anything is on the
// cable. Thread-bound; borrows both arguments.
class PieBridge final : public ScsiDevice {
 public:
  PieBridge(UsbTransport& usb, Clock& clock);

  [[nodiscard]] ScsiReply command(const Cdb& cdb, Duration timeout) override;
  [[nodiscard]] ScsiReply send(const Cdb& cdb, ByteView out, Duration timeout) override;
  // The length field of a READ counts lines; in.size() is the number of bytes.
  [[nodiscard]] ScsiReply receive(const Cdb& cdb, std::span<std::byte> in,
                                  Duration timeout) override;
  void annotate(std::string_view phase) override { usb_.annotate(phase); }

 private:
  ScsiReply transact(const Cdb& cdb, ByteView out, std::span<std::byte> in, Duration timeout);
  ScsiReply transact_once(const Cdb& cdb, ByteView out, std::span<std::byte> in, TimePoint until);
  void select_commands();
  void write_port(std::uint8_t port, std::span<const std::byte> data);
  // Polls while the unit is busy.
  std::uint8_t wait_status(TimePoint until, const Cdb& cdb);
  std::uint8_t read_status();
  // Says how many bytes the following bulk transfers shall carry.
  void announce(std::size_t n_bytes);
  // Returns how many bytes came; fewer than asked for when some got lost.
  std::size_t read_data(std::span<std::byte> in);
  // What came of one announced window.
  std::size_t read_window(std::span<std::byte> in);
  [[nodiscard]] Sense request_sense();
  void resynchronise() override;

  UsbTransport& usb_;
  Clock& clock_;
  Endpoint bulk_in_;
  std::size_t max_packet_bytes_;
  // A transfer failed since the last command; at first, nobody knows how the last program ended.
  bool out_of_step_ = true;
  bool may_have_acted_ = false;  // the last byte of the command was sent, perhaps in vain
  std::vector<std::byte> staging_;
};

}  // namespace reseau::pieusb
