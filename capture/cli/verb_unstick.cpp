#include <memory>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "capture/cli/failure.h"
#include "capture/cli/scan_choice.h"
#include "capture/cli/verbs.h"
#include "drivers/registry.h"

namespace reseau::cli {

namespace {

ExitCode unstick(const std::string& device, Work& work) {
  const std::string name =
      as_failure(Doing::kReadingOptions, [&] { return choose_device(device); });
  nlohmann::ordered_json steps = nlohmann::ordered_json::array();
  const UnstickReport report = as_failure(Doing::kOpeningDevice, [&] {
    return unstick_device(name, [&](const std::string& tried, const std::string& result) {
      work.reporter.say(fmt::format("{}: {}", tried, result));
      steps.push_back({{"tried", tried}, {"result", result}});
    });
  });
  const char* const word = report == UnstickReport::kWasFine  ? "nothing was wrong"
                           : report == UnstickReport::kMended ? "works again"
                                                              : "needs the power switch";
  work.reporter.result_line(word);
  work.reporter.result_json(
      {{"schema", "reseau-unstick/1"}, {"device", name}, {"result", word}, {"steps", steps}});
  return report == UnstickReport::kNeedsPowerSwitch ? kExitDevice : kExitOk;
}

}  // namespace

void add_unstick(Program& program) {
  auto device = std::make_shared<std::string>();
  CLI::App* app = program.add_verb(
      "unstick",
      "For a scanner that no longer does what it is told: waits for a motion that is under way, "
      "ends a\nscan that another program left open, lets the stage return to its origin, starts "
      "the "
      "unit anew;\neach only when the one before did not help. Says when only the power switch is "
      "left (exit code 9).",
      "reseau unstick\n"
      "reseau unstick -d sg:/dev/sg2 --json",
      [device](Work& work) { return unstick(*device, work); });
  program.prints_own_json(app);
  app->add_option("-d,--device-name", *device, "The scanner; default the only one");
}

}  // namespace reseau::cli
