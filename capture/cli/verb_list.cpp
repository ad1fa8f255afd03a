#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "capture/cli/verbs.h"
#include "drivers/registry.h"

namespace reseau::cli {

namespace {

ExitCode list(Work& work) {
  const auto devices = list_devices();
  nlohmann::ordered_json array = nlohmann::ordered_json::array();
  for (const DeviceEntry& device : devices) {
    array.push_back({{"name", device.name},
                     {"description", device.description},
                     {"simulated", device.simulated},
                     {"usable", device.problem.empty()},
                     {"problem", device.problem}});
    work.reporter.result_line(fmt::format("{:<28} {}", device.name, device.description));
    if (!device.problem.empty()) work.reporter.warning(device.name + ": " + device.problem);
  }
  work.reporter.result_json({{"schema", "reseau-list/1"}, {"devices", array}});
  return kExitOk;
}

}  // namespace

void add_list(Program& program) {
  program.prints_own_json(
      program.add_verb("list", "Scanners on the bus, then the simulated ones. Opens none of them.",
                       "reseau list\n"
                       "reseau list --json",
                       list));
}

}  // namespace reseau::cli
