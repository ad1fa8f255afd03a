// A simulated unit behind the kernel's SCSI node: FireWire and parallel SCSI models.
#pragma once

#include <cstdint>
#include <memory>

#include "drivers/scsi/sg_node.h"
#include "drivers/sim/sim_spec.h"
#include "drivers/sim/unit.h"

namespace reseau::sim {

// Answers as the kernel's FireWire driver passes the answers of an LS-9000 on: sense in fixed form,
// Nikon's fourth code at [15]. Counts commands where the USB units count transfers. Thread-bound.
class SimulatedSg final : public SgNode {
 public:
  // Throws InputError for a model that does not exist.
  explicit SimulatedSg(const SimSpec& spec);
  void exchange(SgExchange& exchange) override;

 private:
  UnitSpec faults_;
  Unit unit_;
  std::int64_t n_commands_ = 0;
};

}  // namespace reseau::sim
