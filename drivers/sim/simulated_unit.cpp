#include "drivers/sim/simulated_unit.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "drivers/sim/pie/pie_model.h"
#include "drivers/sim/pie/pie_wire.h"
#include "drivers/sim/simulate.h"
#include "drivers/sim/simulated_sg.h"
#include "drivers/sim/unit_model.h"
#include "drivers/sim/wire.h"

namespace reseau::sim {

std::vector<std::string> simulated_unit_names() {
  std::vector<std::string> names = unit_model_names();
  for (std::string& name : pie::pie_model_names()) names.push_back(std::move(name));
  return names;
}

void check_model(const SimSpec& spec) {
  const std::vector<std::string> names = simulated_unit_names();
  if (std::find(names.begin(), names.end(), spec.model) != names.end()) return;
  std::string known;
  for (const std::string& name : names) known.append(known.empty() ? "" : ", ").append(name);
  throw InputError("There is no simulated model named \"" + spec.model +
                   "\". Known models: " + known + ".");
}

std::unique_ptr<UsbTransport> open_simulated_unit(const SimSpec& spec) {
  check_model(spec);
  if (const pie::PieModel* const model = pie::find_pie_model(spec.model)) {
    return std::make_unique<pie::PieUsb>(*model, spec);
  }
  return std::make_unique<SimulatedUsb>(spec);
}

std::unique_ptr<UsbTransport> open_simulated_unit(std::string_view name) {
  return open_simulated_unit(parse_sim_spec(name));
}

bool is_scsi_model(const SimSpec& spec) {
  const UnitModel* const model = find_unit_model(spec.model);
  return model != nullptr && model->link == LinkKind::kScsi;
}

std::unique_ptr<SgNode> open_simulated_sg(const SimSpec& spec) {
  return std::make_unique<SimulatedSg>(spec);
}

}  // namespace reseau::sim
