#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "capture/bench/reconstruction_bench.h"
#include "capture/cli/quality_plot.h"
#include "capture/cli/verb_bench.h"
#include "capture/cli/write_text.h"
#include "core/base/error.h"

namespace reseau::cli {

namespace {

using nlohmann::ordered_json;

struct ReconstructionBench {
  std::vector<std::string> qualities, demosaics;
  std::string film, only, plot, deconvolve = "auto";
  bool exact = false;
  int n_threads = 0;
};

// A quality, or a demosaic by itself.
struct Method {
  std::string name;
  Quality quality = Quality::kStandard;
  std::optional<Demosaic> demosaic;
};

std::vector<Method> methods_of(const ReconstructionBench& options) {
  std::vector<Method> methods;
  for (const std::string& name : options.qualities)
    methods.push_back({name, parse_quality(name), std::nullopt});
  for (const std::string& name : options.demosaics)
    methods.push_back({name, Quality::kStandard, parse_demosaic(name)});
  if (!methods.empty()) return methods;
  return {{"draft", Quality::kDraft, {}},
          {"standard", Quality::kStandard, {}},
          {"best", Quality::kBest, {}}};
}

ordered_json to_json(const ReconstructionCase& test, const Method& method,
                     const ReconstructionRun& run) {
  ordered_json object{{"name", test.name},
                      {"film", test.film},
                      {"quality", method.name},
                      {"demosaic", demosaic_name(demosaic_of(method.quality, method.demosaic))}};
  object["found"] = run.found;
  if (!run.found) {
    object["reason"] = run.reason;
    return object;
  }
  const PictureScore& s = run.score;
  object["deconvolution"] = deconvolution_name(run.report.deconvolution);
  object["sharpening_noise_gain"] = run.report.sharpening_noise_gain;
  object["full"] = {{"mean", s.full_mean}, {"p99", s.full_p99}, {"psnr_db", s.psnr_db}};
  object["element_scale"] = {{"mean", s.element_mean}, {"p95", s.element_p95}};
  object["patches"] = {{"mean", s.patch_mean}, {"max", s.patch_max}, {"n", s.n_patches}};
  object["sigma_px"] = run.report.sharpness.sigma_px;
  object["cpu_s"] = {{"register", run.register_cpu_s}, {"reconstruct", run.reconstruct_cpu_s}};
  object["wall_s"] = run.reconstruct_wall_s;
  object["skipped"] = run.report.skipped;
  return object;
}

ExitCode bench_reconstruction(const ReconstructionBench& options, Work& work) {
  std::vector<ReconstructionCase> cases = reconstruction_cases();
  if (!options.film.empty()) cases = {{options.film, options.film}};
  std::erase_if(cases, [&options](const ReconstructionCase& test) {
    return test.name.find(options.only) == std::string::npos;
  });
  if (cases.empty()) {
    throw InputError(fmt::format("No film of the table has '{}' in its name.", options.only));
  }
  ordered_json result{{"schema", "reseau-bench-reconstruction/1"},
                      {"cases", ordered_json::array()}};
  work.reporter.result_line(fmt::format("{:<36} {:<9} {:>6} {:>6} {:>8} {:>7} {:>6} {:>7} {:>6}",
                                        "dE00 of 1 megapixel", "quality", "full", "dB", "element",
                                        "patches", "max", "reg. s", "rec. s"));
  std::vector<QualityPoint> points;
  const std::vector<Method> methods = methods_of(options);
  std::optional<Deconvolution> deconvolution;
  if (options.deconvolve != "auto") deconvolution = parse_deconvolution(options.deconvolve);
  for (const ReconstructionCase& test : cases) {
    if (work.signals.stop().stop_requested()) return kExitCancelled;
    const ReconstructionFilm film(test, options.n_threads);
    for (const Method& method : methods) {
      if (work.signals.stop().stop_requested()) return kExitCancelled;
      const ReconstructionRun run =
          film.run(method.quality, method.demosaic, options.exact, deconvolution);
      result["cases"].push_back(to_json(test, method, run));
      const PictureScore& s = run.score;
      if (run.found)
        points.push_back({method.name, run.register_cpu_s + run.reconstruct_cpu_s, s.element_mean});
      work.reporter.result_line(
          run.found
              ? fmt::format("{:<36} {:<9} {:>6.2f} {:>6.2f} {:>8.3f} {:>7.3f} {:>6.3f} "
                            "{:>7.2f} {:>6.2f}",
                            test.name, method.name, s.full_mean, s.psnr_db, s.element_mean,
                            s.patch_mean, s.patch_max, run.register_cpu_s, run.reconstruct_cpu_s)
              : fmt::format("{:<36} {:<9} not registered: {}", test.name, method.name, run.reason));
    }
  }
  for (const QualityMean& mean : quality_means(points)) {
    result["qualities"].push_back({{"quality", mean.quality},
                                   {"cpu_s_per_megapixel", mean.seconds},
                                   {"element_scale_mean", mean.delta_e},
                                   {"on_pareto_front", mean.on_front}});
    work.reporter.result_line(fmt::format("{:<36} {:<9} {:>21.3f} {:>30.2f} s{}", "mean of all",
                                          mean.quality, mean.delta_e, mean.seconds,
                                          mean.on_front ? ", on the Pareto front" : ""));
  }
  work.reporter.result_json(result);
  if (!options.plot.empty()) write_text(options.plot, quality_plot(points), work.reporter);
  return kExitOk;
}

}  // namespace

void add_bench_reconstruction(Program& program, CLI::App* bench) {
  auto options = std::make_shared<ReconstructionBench>();
  CLI::App* app = program.add_verb_below(
      bench, "reconstruction",
      "Reconstructs simulated films, everything automatic, and prints the colour error against "
      "the\nscene (CIEDE2000 of process RGB as linear sRGB) pixel by pixel, after a Gaussian of "
      "0.45 period\n(element), and of flat fields; and the processor time.",
      "reseau bench reconstruction --plot pareto.svg\n"
      "reseau bench reconstruction --quality best --film 'scene=chart&blur_px=1.2' --json",
      [options](Work& work) { return bench_reconstruction(*options, work); });
  program.prints_own_json(app);
  app->add_option("--quality", options->qualities, "draft, standard, best; default all")
      ->check(CLI::IsMember({"draft", "standard", "best"}));
  app->add_option("--demosaic", options->demosaics,
                  "nearest, bilinear, bicubic, ratio, joint: rows of these, instead of or beside "
                  "qualities")
      ->check(CLI::IsMember({"nearest", "bilinear", "bicubic", "ratio", "joint"}));
  app->add_option("--deconvolve", options->deconvolve,
                  "auto (default), none, wiener, richardson-lucy")
      ->check(CLI::IsMember({"auto", "none", "wiener", "richardson-lucy"}));
  app->add_option("--film", options->film,
                  "One film of your own instead of the table, as for 'simulate'");
  app->add_option("--only", options->only, "Only films of the table whose name contains this");
  app->add_option("--plot", options->plot, "Time against error as an SVG file");
  app->add_flag("--exact", options->exact, "No shortcut that changes a pixel");
  app->add_option("--threads", options->n_threads, "Threads; 0 = all cores (default)")
      ->check(CLI::Range(0, 1024));
}

}  // namespace reseau::cli
