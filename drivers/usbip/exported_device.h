// The device side of USB/IP: transfers of a client carried out on a UsbTransport.
#pragma once

#include <cstdint>
#include <deque>
#include <set>
#include <vector>

#include "drivers/usb/usb_transport.h"
#include "drivers/usbip/description.h"
#include "drivers/usbip/messages.h"

namespace reseau::usbip {

// Answers the requests of chapter 9 itself and hands bulk transfers and requests of the vendor's
// own to the unit. An IN transfer that the unit has nothing for waits, as on a bus, until it has,
// or until it is taken back. A failed transfer leaves its endpoint halted until CLEAR_FEATURE.
// Thread-bound; borrows the unit.
class ExportedDevice {
 public:
  ExportedDevice(DeviceDescription description, UsbTransport& unit);

  // Appends what ended: this transfer, others that waited, or nothing yet.
  void submit(SubmitRequest request, std::vector<Completion>& done);
  [[nodiscard]] Completion unlink(const UnlinkRequest& request);
  // The client is gone: nothing waits any more, the unit sees a reset of the bus.
  void detach();
  // The unit was unplugged.
  [[nodiscard]] bool gone() const { return gone_; }
  [[nodiscard]] const DeviceDescription& description() const { return description_; }
  [[nodiscard]] DeviceSummary summary() const;
  [[nodiscard]] std::size_t n_waiting() const { return waiting_.size(); }

 private:
  struct Waiting {
    std::uint32_t sequence = 0;
    std::uint8_t address = 0;
    std::uint32_t length = 0, flags = 0, n_packets = 0;
    bool stuck = false;  // until taken back
    bool held = false;   // behind a short transfer that was not to be short
  };

  void control(const SubmitRequest& request, std::vector<Completion>& done);
  [[nodiscard]] Completion standard(const SubmitRequest& request);
  void vendor(const SubmitRequest& request, std::vector<Completion>& done);
  // A negative errno, or the data of an IN request.
  [[nodiscard]] std::int32_t standard(ByteView setup, Bytes& reply);
  [[nodiscard]] std::int32_t get_status(std::uint8_t recipient, std::uint16_t index, Bytes& reply);
  [[nodiscard]] std::int32_t set_halt(std::uint16_t index, bool halted);
  [[nodiscard]] bool has_endpoint(std::uint16_t address) const;
  // False when the unit is gone.
  [[nodiscard]] bool reset_unit();
  void bulk_out(const SubmitRequest& request, std::vector<Completion>& done);
  void serve(std::vector<Completion>& done);
  // False when the unit has nothing.
  [[nodiscard]] bool serve_one(std::size_t index, std::vector<Completion>& done);

  DeviceDescription description_;
  UsbTransport& unit_;
  std::deque<Waiting> waiting_;  // IN transfers, and OUT transfers that nobody takes
  std::set<std::uint8_t> halted_;
  Bytes buffer_;
  std::uint8_t configuration_ = 1;
  bool asked_in_vain_ = false;  // nothing has changed since the unit had nothing
  bool gone_ = false;
};

}  // namespace reseau::usbip
