#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "capture/bench/memory_use.h"
#include "capture/bench/speed_bench.h"
#include "capture/cli/speed_plot.h"
#include "capture/cli/verb_bench.h"
#include "capture/cli/write_text.h"
#include "capture/image/scan_reader.h"

namespace reseau::cli {

namespace {

using nlohmann::ordered_json;

struct SpeedArguments {
  std::vector<double> megapixels{1, 4, 24, 60, 116};
  std::vector<int> threads{1, 2};
  std::vector<std::string> qualities{"draft", "standard", "best"};
  int repeat = 3;
  bool half_black = false, exact = false;
  std::string scan, plot;
};

// What is registered and reconstructed.
struct Film {
  MemoryLineSource source;
  ToneCurves tone = ToneCurves::linear();
  [[nodiscard]] double megapixels() const {
    return 1e-6 * source.format().width_px * source.format().n_lines;
  }
};

Film film_of_file(const std::string& file) {
  const Scan scan = as_failure(Doing::kReadingInput, [&] { return read_scan(file); });
  const LineFormat& format = scan.source->format();
  std::vector<std::uint16_t> samples(format.samples_per_line() *
                                     static_cast<std::size_t>(format.n_lines));
  as_failure(Doing::kReadingInput, [&] {
    scan.source->read(0, format.n_lines, samples);
    return true;
  });
  return {{format, std::move(samples)}, scan.tone};
}

// What the whole of a picture may take on two threads [s].
struct SpeedBar {
  double megapixels;
  Quality quality;
  double wall_s;
};
constexpr std::array kSpeedBars{SpeedBar{24, Quality::kStandard, 1.0},
                                SpeedBar{24, Quality::kBest, 6.0},
                                SpeedBar{116, Quality::kStandard, 6.0}};
constexpr double kMemoryBarMb = 400;  // at 24 megapixels, standard

std::optional<double> bar_of(const SpeedCase& test) {
  for (const SpeedBar& bar : kSpeedBars) {
    if (bar.megapixels == test.megapixels && bar.quality == test.quality && test.n_threads == 2)
      return bar.wall_s;
  }
  return std::nullopt;
}

std::string row_text(const SpeedPoint& p, const SpeedRun& run, double share,
                     std::optional<double> bar) {
  const double mb = static_cast<double>(run.extra_bytes) * 1e-6;
  std::string text =
      fmt::format("{:>6.0f} {:<9} {:>7} {:>8.2f} {:>8.2f} {:>8.2f} {:>8.2f} {:>7.0f} {:>7.1f}",
                  p.megapixels, p.quality, p.n_threads, run.register_wall_s, run.register_cpu_s,
                  run.reconstruct_wall_s, run.reconstruct_cpu_s, mb, 100 * share);
  if (bar) text += fmt::format("  {:.1f} s {}", *bar, run.wall_s() <= *bar ? "kept" : "MISSED");
  if (bar && p.megapixels == kSpeedBars[0].megapixels && p.quality == "standard")
    text += fmt::format(", {:.0f} MB {}", kMemoryBarMb, mb <= kMemoryBarMb ? "kept" : "MISSED");
  return text;
}

ExitCode bench_speed(const SpeedArguments& options, Work& work) {
  ordered_json result{
      {"schema", "reseau-bench-speed/1"}, {"half_black", options.half_black},
      {"exact", options.exact},           {"scan", options.scan},
      {"repeat", options.repeat},         {"bandwidth_bytes_per_s", ordered_json::array()},
      {"cases", ordered_json::array()}};
  std::vector<double> bandwidth;
  for (const int n : options.threads) {
    bandwidth.push_back(copy_bandwidth(n));
    result["bandwidth_bytes_per_s"].push_back({{"threads", n}, {"value", bandwidth.back()}});
  }
  work.reporter.result_line(fmt::format("{:>6} {:<9} {:>7} {:>8} {:>8} {:>8} {:>8} {:>7} {:>7}",
                                        "Mpx", "quality", "threads", "reg. s", "cpu s", "rec. s",
                                        "cpu s", "MB", "% bw"));
  std::vector<SpeedPoint> points;
  // Films of the sizes asked for, or the one of a file, whatever its size.
  const std::vector<double> sizes = options.scan.empty() ? options.megapixels : std::vector{0.0};
  for (const double size : sizes) {
    const Film film = options.scan.empty() ? Film{tiled_film(size, options.half_black)}
                                           : film_of_file(options.scan);
    const double megapixels = options.scan.empty() ? size : film.megapixels();
    for (const std::string& quality : options.qualities) {
      for (std::size_t i = 0; i < options.threads.size(); ++i) {
        if (work.signals.stop().stop_requested()) return kExitCancelled;
        const SpeedCase test{megapixels,         options.half_black, parse_quality(quality),
                             options.threads[i], options.exact,      film.tone};
        const SpeedRun run = run_speed_case(film.source, test, options.repeat);
        if (!run.found) {
          work.reporter.result_line(
              fmt::format("{:>6.0f} {:<9} not registered: {}", megapixels, quality, run.reason));
          result["cases"].push_back(
              {{"megapixels", megapixels}, {"found", false}, {"reason", run.reason}});
          continue;
        }
        const double share = run.least_bytes / run.wall_s() / bandwidth[i];
        const std::optional<double> bar = bar_of(test);
        points.push_back({megapixels, quality, test.n_threads, run.wall_s()});
        work.reporter.result_line(row_text(points.back(), run, share, bar));
        ordered_json row{
            {"megapixels", megapixels},
            {"found", true},
            {"quality", quality},
            {"threads", test.n_threads},
            {"wall_s",
             {{"register", run.register_wall_s}, {"reconstruct", run.reconstruct_wall_s}}},
            {"cpu_s", {{"register", run.register_cpu_s}, {"reconstruct", run.reconstruct_cpu_s}}},
            {"peak_bytes_beyond_scan", run.extra_bytes},
            {"share_of_bandwidth", share}};
        if (bar) row["bar_wall_s"] = *bar;
        result["cases"].push_back(row);
      }
    }
  }
  work.reporter.result_json(result);
  if (!options.plot.empty()) write_text(options.plot, speed_plot(points), work.reporter);
  return kExitOk;
}

}  // namespace

void add_bench_speed(Program& program, CLI::App* bench) {
  auto options = std::make_shared<SpeedArguments>();
  CLI::App* app = program.add_verb_below(
      bench, "speed",
      "Registers and reconstructs films of 1 to 116 megapixels in memory, everything automatic. "
      "Time of the\nfastest run and processor time; most memory beyond scan and picture; and the "
      "bytes that have to move\n(the scan twice, the picture once) in that time as a share of what "
      "the machine copies.",
      "reseau bench speed --megapixels 24 --threads 2\n"
      "reseau bench speed --scan film.tif --quality standard\n"
      "reseau bench speed --plot speed.svg --json",
      [options](Work& work) { return bench_speed(*options, work); });
  program.prints_own_json(app);
  app->add_option("--megapixels", options->megapixels, "Sizes; default 1 4 24 60 116")
      ->check(CLI::Range(0.2, 400.0))
      ->delimiter(',');
  app->add_option("--threads", options->threads, "Numbers of threads; default 1 2; 0 = all cores")
      ->check(CLI::Range(0, 1024))
      ->delimiter(',');
  app->add_option("--quality", options->qualities, "draft, standard, best; default all")
      ->check(CLI::IsMember({"draft", "standard", "best"}))
      ->delimiter(',');
  app->add_option("--repeat", options->repeat, "Runs of each (default 3)")
      ->check(CLI::Range(1, 100));
  app->add_option("--scan", options->scan, "This TIFF instead of films of those sizes")
      ->excludes("--megapixels");
  app->add_flag("--half-black", options->half_black, "No light on one half of the film");
  app->add_flag("--exact", options->exact, "No shortcut that changes a pixel");
  app->add_option("--plot", options->plot, "Size against time as an SVG file");
}

}  // namespace reseau::cli
