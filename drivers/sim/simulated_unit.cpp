#include "drivers/sim/simulated_unit.h"

#include "drivers/sim/wire.h"

namespace reseau::sim {

std::unique_ptr<UsbTransport> open_simulated_unit(const SimSpec& spec) {
  return std::make_unique<SimulatedUsb>(spec);
}

std::unique_ptr<UsbTransport> open_simulated_unit(std::string_view name) {
  return open_simulated_unit(parse_sim_spec(name));
}

}  // namespace reseau::sim
