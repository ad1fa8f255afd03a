#include <memory>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "capture/cli/difference.h"
#include "capture/cli/verbs.h"
#include "capture/session/json_number.h"

namespace reseau::cli {

namespace {

struct Options {
  std::string a, b;
};

nlohmann::ordered_json figures_json(const DifferenceFigures& figures) {
  nlohmann::ordered_json object = nlohmann::ordered_json::object();
  put_number(object, "mean", figures.mean);
  put_number(object, "median", figures.median);
  put_number(object, "p95", figures.p95);
  put_number(object, "max", figures.max);
  return object;
}

std::string figures_text(const DifferenceFigures& f) {
  return fmt::format("mean {:.4f}  median {:.4f}  95 % {:.4f}  max {:.4f}", f.mean, f.median, f.p95,
                     f.max);
}

ExitCode run_compare(const Options& options, Work& work) {
  const Difference d = as_failure(Doing::kReadingInput, [&] {
    return compare_pictures(options.a, options.b, work.signals.stop());
  });
  if (work.signals.count() > 0) {
    work.reporter.warning("Stopped.");
    return kExitCancelled;
  }
  if (d.n_pixels == 0) {
    throw Failure(kExitInput,
                  "No pixel of the two pictures is finite; there is nothing to compare.");
  }
  nlohmann::ordered_json object = {
      {"schema", "reseau-compare/1"},
      {"a", options.a},
      {"b", options.b},
      {"width_px", d.width_px},
      {"height_px", d.height_px},
      {"pixels", d.n_pixels},
      {"not_finite", d.n_not_finite},
      {"identical", d.identical},
      {"delta_e_2000", figures_json(d.all)},
      {"delta_e_2000_without_worst_1_percent", figures_json(d.without_worst_percent)}};
  put_number(object, "max_abs_difference", d.max_abs);
  work.reporter.result_json(object);
  work.reporter.result_line("ΔE2000                     " + figures_text(d.all));
  work.reporter.result_line("ΔE2000 without worst 1 %   " + figures_text(d.without_worst_percent));
  if (d.n_not_finite > 0) {
    work.reporter.warning(fmt::format(
        "{} pixels are not finite in one of the pictures and were left out.", d.n_not_finite));
  }
  if (d.identical) work.reporter.result_line("The pictures are identical.");
  return kExitOk;
}

}  // namespace

void add_compare(Program& program) {
  auto options = std::make_shared<Options>();
  CLI::App* app = program.add_verb("compare",
                                   "Colour difference (CIEDE2000) of two EXR pictures of the same "
                                   "size, pixel by pixel, each read "
                                   "with\nits own chromaticities.",
                                   "reseau compare box3_07.exr again/box3_07.exr\n"
                                   "reseau compare truth.exr reconstruction.exr --json",
                                   [options](Work& work) { return run_compare(*options, work); });
  app->add_option("A", options->a, "An EXR picture")->required();
  app->add_option("B", options->b, "Another")->required();
  program.prints_own_json(app);
}

}  // namespace reseau::cli
