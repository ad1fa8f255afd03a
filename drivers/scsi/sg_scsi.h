#pragma once

#include <memory>

#include "drivers/scsi/scsi_device.h"
#include "drivers/scsi/scsi_link.h"
#include "drivers/scsi/sg_node.h"

namespace reseau {

// Sense data as the kernel delivers it, fixed (70, 71) or descriptor (72, 73) form. Nikon's fourth
// code stands at [15] of the fixed form, where the FireWire driver and Windows put it (seen on an
// LS-9000).
[[nodiscard]] Sense decode_sense_data(ByteView data);

// SCSI commands to a node of the kernel: FireWire and parallel SCSI models. A unit that answers
// BUSY is asked again until the time is over; a reservation of another host is an error. Never
// sends a command twice that was executed. Thread-bound; borrows the clock.
class SgScsi final : public ScsiDevice {
 public:
  SgScsi(std::unique_ptr<SgNode> node, Clock& clock) : node_(std::move(node)), clock_(clock) {}

  [[nodiscard]] ScsiReply command(const Cdb& cdb, Duration timeout) override;
  [[nodiscard]] ScsiReply send(const Cdb& cdb, ByteView out, Duration timeout) override;
  [[nodiscard]] ScsiReply receive(const Cdb& cdb, std::span<std::byte> in,
                                  Duration timeout) override;
  void annotate(std::string_view /*phase*/) override {}

 private:
  ScsiReply transact(const Cdb& cdb, ByteView out, std::span<std::byte> in, Duration timeout);

  std::unique_ptr<SgNode> node_;
  Clock& clock_;
};

[[nodiscard]] ScsiLink sg_scsi_link(std::unique_ptr<SgNode> node, Clock& clock);

}  // namespace reseau
