#include "drivers/sim/simulated_unit.h"

#include "drivers/sim/simulated_sg.h"
#include "drivers/sim/unit_model.h"
#include "drivers/sim/wire.h"

namespace reseau::sim {

std::unique_ptr<UsbTransport> open_simulated_unit(const SimSpec& spec) {
  return std::make_unique<SimulatedUsb>(spec);
}

std::unique_ptr<UsbTransport> open_simulated_unit(std::string_view name) {
  return open_simulated_unit(parse_sim_spec(name));
}

bool is_scsi_model(const SimSpec& spec) { return unit_model(spec.model).link == LinkKind::kScsi; }

std::unique_ptr<SgNode> open_simulated_sg(const SimSpec& spec) {
  return std::make_unique<SimulatedSg>(spec);
}

}  // namespace reseau::sim
