#include <memory>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "capture/cli/verbs.h"
#include "capture/session/json_number.h"
#include "core/color/element_color.h"

namespace reseau::cli {

namespace {

struct Options {
  std::string name;
  std::string balance = "neutral";
  std::string space = "srgb-linear";
};

ExitCode list(Work& work) {
  const auto names = primary_set_names();
  for (const std::string& name : names) work.reporter.result_line(name);
  work.reporter.result_json(
      {{"schema", "reseau-colour-list/1"}, {"default", names.front()}, {"primaries", names}});
  return kExitOk;
}

nlohmann::ordered_json matrix_json(const Matrix3& m) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < 9; i += 3) {
    rows.push_back({number_or_null(m[i]), number_or_null(m[i + 1]), number_or_null(m[i + 2])});
  }
  return rows;
}

ExitCode show(const Options& options, Work& work) {
  const ColorModel model = as_failure(Doing::kReadingOptions, [&] {
    return make_color_model(options.name.empty() ? primary_set_names().front() : options.name,
                            parse_balance(options.balance), parse_output_space(options.space));
  });
  nlohmann::ordered_json chromaticities = nlohmann::ordered_json::array();
  for (const auto& xy : model.chromaticities.xy) {
    chromaticities.push_back({number_or_null(xy[0]), number_or_null(xy[1])});
  }
  work.reporter.result_json({{"schema", "reseau-colour/1"},
                             {"primaries", model.primaries},
                             {"balance", options.balance},
                             {"space", options.space},
                             {"output_from_process", matrix_json(model.output_from_process)},
                             {"xyz_from_process", matrix_json(model.xyz_from_process)},
                             {"chromaticities_rgbw", chromaticities}});
  work.reporter.result_line(fmt::format("{}, balance {}: {} from element intensities",
                                        model.primaries, options.balance, options.space));
  for (std::size_t i = 0; i < 9; i += 3) {
    const auto& m = model.output_from_process;
    work.reporter.result_line(fmt::format("{:10.6f} {:10.6f} {:10.6f}", m[i], m[i + 1], m[i + 2]));
  }
  return kExitOk;
}

}  // namespace

void add_colour(Program& program) {
  CLI::App* group = program.add_group("colour", "Colours of the elements.",
                                      "reseau colour list\n"
                                      "reseau colour show cornwell-clyne-1951");
  program.prints_own_json(program.add_verb_below(
      group, "list", "Sets of primaries that --primaries knows; the first is the default.",
      "reseau colour list\n"
      "reseau colour list --json",
      list));
  auto options = std::make_shared<Options>();
  CLI::App* app = program.add_verb_below(
      group, "show", "The matrix from element intensities to an output space.",
      "reseau colour show\n"
      "reseau colour show cornwell-clyne-1951 --space xyz --balance none --json",
      [options](Work& work) { return show(*options, work); });
  app->add_option("NAME", options->name, "A set of primaries; default the first");
  app->add_option("--balance", options->balance, "none, brightness, neutral (default) or bradford");
  app->add_option("--space", options->space, "process, xyz or srgb-linear (default)");
  program.prints_own_json(app);
}

}  // namespace reseau::cli
