#include <algorithm>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "capture/cli/develop_choice.h"
#include "capture/cli/verbs.h"
#include "capture/image/exr_file.h"
#include "capture/store/master_writer.h"
#include "core/color/element_color.h"
#include "drivers/sim/simulate.h"

namespace reseau::cli {

namespace {

struct Options {
  std::vector<std::string> keys;
  std::optional<std::uint64_t> seed;
  std::string output, truth;
};

sim::SimSpec spec_of(const Options& options) {
  std::string name = "sim:ls5000";
  char separator = '?';
  for (const std::string& key : options.keys) {
    name += separator + key;
    separator = '&';
  }
  if (options.seed) name += fmt::format("{}seed={}", separator, *options.seed);
  return sim::parse_sim_spec(name);
}

void write_scan(const sim::SimulatedScan& scan, const std::filesystem::path& path, Work& work) {
  constexpr int kLinesAtOnce = 64;
  MasterOptions options;
  options.path = path;
  MasterWriter writer(options);
  CaptureContext context;
  context.device_name = "sim";
  context.model = "simulated film";
  writer.begin(scan.format, context);
  const int n_lines = scan.format.n_lines;
  LineBlock block;
  block.width_px = scan.format.width_px;
  block.n_channels = scan.format.n_channels();
  const std::size_t per_line = scan.format.samples_per_line();
  const std::span<const std::uint16_t> all(scan.samples);
  work.reporter.phase("write", path.string());
  try {
    for (int y = 0; y < n_lines; y += kLinesAtOnce) {
      block.first_line = y;
      block.n_lines = std::min(kLinesAtOnce, n_lines - y);
      const auto part = all.subspan(static_cast<std::size_t>(y) * per_line,
                                    static_cast<std::size_t>(block.n_lines) * per_line);
      block.samples.assign(part.begin(), part.end());
      writer.lines(block);
    }
  } catch (...) {
    writer.end(ScanEnd::kFailed);
    throw;
  }
  writer.end(ScanEnd::kComplete);
  if (writer.result().error) std::rethrow_exception(writer.result().error);
}

// Process RGB, and u and v where there is a réseau.
void write_truth(const sim::SimulatedScan& scan, const std::filesystem::path& path, Work& work) {
  const bool screen = scan.truth.has_screen();
  std::vector<std::string> channels{"R", "G", "B"};
  if (screen) channels.insert(channels.end(), {"u", "v"});
  ExrOptions exr;
  exr.chromaticities =
      make_color_model(primary_set_names().front(), Balance::kNeutral, OutputSpace::kProcess)
          .chromaticities;
  const int width = scan.format.width_px;
  const int height = scan.format.n_lines;
  FloatImageWriter writer(path, width, height, channels, exr);
  const auto n = static_cast<std::size_t>(width);
  std::vector<float> red(n), green(n), blue(n), row;
  std::vector<sim::ScreenPoint> points(n);
  work.reporter.phase("truth", path.string());
  for (int y = 0; y < height; ++y) {
    scan.truth.process_row(y, {red, green, blue});
    if (screen) scan.truth.screen_row(y, points);
    row.clear();
    for (std::size_t x = 0; x < n; ++x) {
      row.insert(row.end(), {red[x], green[x], blue[x]});
      if (!screen) continue;
      row.push_back(static_cast<float>(points[x].u));
      row.push_back(static_cast<float>(points[x].v));
    }
    writer.rows(y, 1, row);
    work.reporter.progress("truth", {double(y + 1), double(height), "lines", 0});
    if (work.signals.stop().stop_requested()) return;
  }
  writer.finish();
}

ExitCode run_simulate(const Options& options, Work& work) {
  const sim::SimSpec spec = as_failure(Doing::kReadingOptions, [&] { return spec_of(options); });
  for (const std::string& file : {options.output, options.truth}) {
    if (file.empty()) continue;
    refuse_existing(file);
    const auto parent = std::filesystem::path(file).parent_path();
    if (!parent.empty()) prepare_directory(parent);
  }
  work.reporter.say(fmt::format("{} × {} px, seed {}, to {}", spec.film.frame.width_px,
                                spec.film.frame.height_px, spec.film.seed, options.output));
  work.reporter.phase("render", "");
  const sim::SimulatedScan scan =
      as_failure(Doing::kReadingOptions, [&] { return sim::simulate_frame(spec); });
  if (work.signals.count() == 0) {
    as_failure(Doing::kWriting, [&] {
      write_scan(scan, options.output, work);
      if (!options.truth.empty()) write_truth(scan, options.truth, work);
    });
  }
  if (work.signals.count() > 0) {
    work.reporter.warning("Stopped.");
    return kExitCancelled;
  }
  work.reporter.event("file", {{"role", "scan"}, {"path", options.output}});
  if (!options.truth.empty()) {
    work.reporter.event("file", {{"role", "truth"}, {"path", options.truth}});
  }
  work.reporter.result_line(options.output);
  return kExitOk;
}

}  // namespace

void add_simulate(Program& program) {
  auto options = std::make_shared<Options>();
  CLI::App* app = program.add_verb(
      "simulate",
      "Renders the simulated film straight to a TIFF, as a perfect transport would scan it. The "
      "truth is an\nEXR with R, G, B (process RGB: 1 = clear film behind that element) and u, v "
      "(periods of the réseau)\nof every pixel. The same keys and seed give the same file.\n\n"
      "Keys:\n" +
          sim::sim_key_help(),
      "reseau simulate -o film.tif --seed 7\n"
      "reseau simulate width_px=800 height_px=600 scene=natural -o film.tif --truth truth.exr",
      [options](Work& work) { return run_simulate(*options, work); });
  app->add_option("KEY=VALUE", options->keys, "Properties of film, optics and sensor");
  app->add_option("--seed", options->seed, "Seed of scene and noise");
  app->add_option("-o,--output", options->output, "The TIFF; must not exist")->required();
  app->add_option("--truth", options->truth, "The EXR with what is known; must not exist");
}

}  // namespace reseau::cli
