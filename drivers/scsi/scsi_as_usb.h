#pragma once

#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "drivers/scsi/scsi_device.h"
#include "drivers/scsi/scsi_link.h"
#include "drivers/usb/usb_transport.h"

namespace reseau {

// The opposite of NikonUsbScsi: a SCSI unit seen through Nikon's USB wrapper. With it sessions of
// FireWire and SCSI units are recorded, replayed and shown like those of USB units. Its product id
// is kScsiProductId, which no unit has. Thread-bound; owns the link.
class ScsiAsUsb final : public UsbTransport {
 public:
  static constexpr std::uint16_t kScsiProductId = 0;
  explicit ScsiAsUsb(ScsiLink link);

  [[nodiscard]] const UsbIdentity& identity() const override { return identity_; }
  void bulk_out(Endpoint endpoint, std::span<const std::byte> data, Duration timeout) override;
  std::size_t bulk_in(Endpoint endpoint, std::span<std::byte> buffer, Duration timeout) override;
  void clear_halt(Endpoint /*endpoint*/) override {}
  void reset() override;

 private:
  void answer(const ScsiReply& reply, Bytes data);

  ScsiLink link_;
  UsbIdentity identity_;
  Bytes cdb_;  // waits for its phase query, or for its data
  bool wants_data_ = false;
  std::deque<Bytes> answers_;
};

}  // namespace reseau
