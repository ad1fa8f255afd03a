#include <memory>
#include <span>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "capture/cli/color_choice.h"
#include "capture/cli/develop_choice.h"
#include "capture/cli/verb_colour.h"
#include "capture/image/space_icc.h"
#include "capture/store/part_file.h"

namespace reseau::cli {

namespace {

struct ColourProfileArguments {
  ColorChoice color;
  std::string curve = "linear";
  std::string output;
};

ExitCode run_colour_profile(const ColourProfileArguments& options, Work& work) {
  const std::vector<std::byte> icc = as_failure(Doing::kReadingOptions, [&] {
    return picture_icc(options.color.resolve(work.reporter), parse_icc_encoding(options.curve));
  });
  const std::string path =
      options.output.empty() ? "reseau-" + options.color.space + ".icc" : options.output;
  refuse_existing(path);
  as_failure(Doing::kWriting, [&] {
    PartFile file(path, PartFile::Kind::kScratch, Existing::kRefuse);
    file.write_at(0, icc);
    file.publish();
  });
  work.reporter.result_line(path);
  work.reporter.result_json({{"schema", "reseau-colour-profile/1"},
                             {"file", path},
                             {"space", options.color.space},
                             {"curve", options.curve},
                             {"bytes", icc.size()}});
  return kExitOk;
}

}  // namespace

void add_colour_profile(Program& program, CLI::App* group) {
  auto options = std::make_shared<ColourProfileArguments>();
  CLI::App* app = program.add_verb_below(
      group, "profile",
      "Writes an ICC profile (version 4) of a space that pictures can be in; of 'process' and "
      "'film' for a\nset of primaries. The same options give the same bytes. Refuses a name that "
      "is taken.",
      "reseau colour profile --space prophoto -o prophoto-linear.icc\n"
      "reseau colour profile harrison-horner-1939 --space process --balance brightness -o film.icc",
      [options](Work& work) { return run_colour_profile(*options, work); });
  app->add_option("NAME", options->color.primaries,
                  "A set of 'reseau colour list', or a CSV file; default the first set");
  app->add_option("-o,--output", options->output, "The file; default reseau-SPACE.icc")
      ->group("Files");
  app->add_option("--curve", options->curve,
                  "Of the samples: linear (default), srgb, or a gamma as 1.8")
      ->group("Colour");
  options->color.add_to(*app, false);
  program.prints_own_json(app);
}

}  // namespace reseau::cli
