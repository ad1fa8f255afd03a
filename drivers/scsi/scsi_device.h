// The boundary to one SCSI logical unit: commands out, status and sense back. Behind it stands the
// SCSI-over-USB wrapper of the Coolscan units.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "core/base/clock.h"
#include "drivers/bytes.h"
#include "drivers/scsi/cdb.h"
#include "drivers/scsi/sense.h"

namespace reseau {

struct ScsiReply {
  bool good = true;  // SCSI status 00; otherwise sense says why
  Sense sense;
  std::size_t received = 0;  // bytes written into `in`
};

// Thread-bound. A check condition is a value; DeviceError means that the transport failed.
class ScsiDevice {
 public:
  virtual ~ScsiDevice() = default;
  // A command without data.
  [[nodiscard]] virtual ScsiReply command(const Cdb& cdb, Duration timeout) = 0;
  // A command that sends `out`; the length in the CDB is out.size().
  [[nodiscard]] virtual ScsiReply send(const Cdb& cdb, ByteView out, Duration timeout) = 0;
  // A command that fills `in`; the length in the CDB is in.size(). A unit that refuses sends none.
  [[nodiscard]] virtual ScsiReply receive(const Cdb& cdb, std::span<std::byte> in,
                                          Duration timeout) = 0;
  // Passed on to the transport, for recordings.
  virtual void annotate(std::string_view phase) = 0;
  // Drops answers that belong to no command of ours: a program that died in the middle of one
  // leaves them. Nothing to do on a link that keeps commands and answers together.
  virtual void resynchronise() {}
};

}  // namespace reseau
