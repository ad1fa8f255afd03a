#include <memory>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "capture/cli/places.h"
#include "capture/cli/verbs.h"
#include "drivers/registry.h"

namespace reseau::cli {

namespace {

const char* level_word(Finding::Level level) {
  switch (level) {
    case Finding::Level::kOk:
      return "ok";
    case Finding::Level::kWarning:
      return "warning";
    case Finding::Level::kProblem:
      return "problem";
  }
  return "problem";
}

ExitCode doctor(const std::string& output, Work& work) {
  std::vector<Finding> findings = diagnose_devices();
  for (Finding& finding : diagnose_places(output)) findings.push_back(std::move(finding));
  nlohmann::ordered_json array = nlohmann::ordered_json::array();
  bool healthy = true;
  for (const Finding& finding : findings) {
    healthy = healthy && finding.level != Finding::Level::kProblem;
    array.push_back({{"level", level_word(finding.level)},
                     {"what", finding.what},
                     {"detail", finding.detail},
                     {"try", finding.remedy}});
    work.reporter.result_line(
        fmt::format("{:<8} {}: {}", level_word(finding.level), finding.what, finding.detail));
    if (!finding.remedy.empty()) {
      work.reporter.result_line(fmt::format("{:<8} try: {}", "", finding.remedy));
    }
  }
  work.reporter.result_json(
      {{"schema", "reseau-doctor/1"}, {"healthy", healthy}, {"findings", array}});
  return healthy ? kExitOk : kExitDevice;
}

}  // namespace

void add_doctor(Program& program) {
  auto output = std::make_shared<std::string>(".");
  CLI::App* app = program.add_verb(
      "doctor",
      "Looks at everything that can keep a scan from starting, and says what mends it. Changes "
      "nothing.\nExit code 0 when nothing is in the way, 9 otherwise.",
      "reseau doctor\n"
      "reseau doctor -o /media/scans --json",
      [output](Work& work) { return doctor(*output, work); });
  app->add_option("-o,--output", *output, "The folder that scans will go to; default here");
  program.prints_own_json(app);
}

}  // namespace reseau::cli
