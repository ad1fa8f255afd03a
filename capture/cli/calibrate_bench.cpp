#include "capture/cli/calibrate_bench.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "capture/cli/bench_scan.h"
#include "capture/cli/develop_choice.h"
#include "capture/cli/event_log.h"
#include "capture/cli/failure.h"
#include "capture/cli/scan_talk.h"
#include "capture/store/names.h"
#include "core/base/error.h"
#include "drivers/registry.h"

namespace reseau::cli {
namespace {

constexpr int kGateLines = 96;
constexpr int kMostEdges = 40;       // all over the field
constexpr double kRandom_mm = 2;     // of the target's three or so
constexpr double kFallWanted = 0.9;  // of the modulation, at both ends of a focus sweep
constexpr int kMostWidenings = 3;

std::unique_ptr<Scanner> open_with(const std::string& device, Reporter& reporter) {
  OpenedScanner opened =
      as_failure(Doing::kOpeningDevice, [&] { return open_scanner(device, {}); });
  reporter.say(device_line(opened.scanner->capabilities()));
  return std::move(opened.scanner);
}

ScanPlan plan_of(const Scanner& scanner, const ScanRequest& request, Reporter& reporter,
                 bool loud) {
  const Negotiated negotiated =
      as_failure(Doing::kReadingOptions, [&] { return scanner.negotiate(request); });
  if (loud) {
    for (const Adjustment& a : negotiated.adjusted) reporter.say(adjustment_line(a));
  }
  return negotiated.plan;
}

// The same place as a rectangle of a scan that `plan` made.
AreaRequest area_of(const ScanRequest& request, const ScanPlan& plan, const PixelRect& roi) {
  const double mm_x = kMmPerInch / plan.format.x_dpi, mm_y = kMmPerInch / plan.format.y_dpi;
  return {request.area.left_mm.value_or(0) + roi.x * mm_x,
          request.area.top_mm.value_or(0) + roi.y * mm_y, roi.width * mm_x, roi.height * mm_y};
}

// The first of the edges, which are in the order of how well they were measured.
const MeasuredEdge* edge_for_focus(const MeasuredFile& file) {
  return file.edges.empty() || !file.edges.front().measured() ? nullptr : &file.edges.front();
}

std::optional<FocusShot> shoot(Scanner& scanner, const ScanRequest& base, int position,
                               double window_px, Work& work) {
  ScanRequest request = base;
  request.focus.mode = FocusRequest::Mode::kPosition;
  request.focus.position = position;
  const auto scan = scan_to_memory(scanner, plan_of(scanner, request, work.reporter, false), work);
  if (!scan) return std::nullopt;
  FocusShot shot;
  shot.position = scan->context.focus_position.value_or(position);
  EdgeOptions options;
  options.window_px = window_px;
  options.lowest = 0;
  options.highest = 1;
  options.quantum = 1.0 / 65535;
  options.with_profile = true;
  shot.edge.roi = {0, 0, scan->width_px, scan->n_lines};
  for (std::size_t c = 0; c < scan->light.size(); ++c) {
    if (scan->light[c].empty()) continue;
    shot.edge.channels.push_back(
        {kProfileChannelNames[c],
         measure_edge(Span2D<const float>(scan->light[c].data(), scan->width_px, scan->n_lines),
                      options)});
  }
  return shot;
}

// Modulation at a frequency of green, or of the first channel.
double followed(const FocusShot& shot) {
  const ChannelEdge* best = nullptr;
  for (const ChannelEdge& c : shot.edge.channels) {
    if (best == nullptr || c.channel == "green") best = &c;
  }
  if (best == nullptr || !best->measured.mtf.all.mtf50) return 0;
  return best->measured.mtf.all.mtf50->f_cy_per_px;
}

bool sweep_focus(Scanner& scanner, const BenchChoice& choice, const ScanRequest& base, int middle,
                 double window_px, Work& work, std::vector<FocusShot>& shots) {
  const Capabilities& able = scanner.capabilities();
  std::set<int> done;
  const auto take = [&](int position) {
    if (position < able.focus_min || position > able.focus_max || !done.insert(position).second) {
      return true;
    }
    auto shot = shoot(scanner, base, position, window_px, work);
    if (!shot) return false;
    work.reporter.say(fmt::format("focus {:>4}: MTF50 {:.4f}", shot->position, followed(*shot)));
    shots.push_back(std::move(*shot));
    return true;
  };
  const auto by_position = [](const FocusShot& a, const FocusShot& b) {
    return a.position < b.position;
  };
  int step = choice.focus_step, reach = choice.focus_step * (choice.focus_positions / 2);
  for (int k = -reach; k <= reach; k += step) {
    if (!take(middle + k)) return false;
  }
  // Until both ends have lost enough for the peak and its width to be known.
  for (int round = 0; round < kMostWidenings; ++round) {
    std::ranges::sort(shots, by_position);
    double most = 0;
    for (const FocusShot& shot : shots) most = std::max(most, followed(shot));
    if (shots.size() < 3 || (followed(shots.front()) < kFallWanted * most &&
                             followed(shots.back()) < kFallWanted * most)) {
      break;
    }
    step *= 2;
    for (int k = 1; k <= 2; ++k) {
      if (!take(middle - reach - k * step) || !take(middle + reach + k * step)) return false;
    }
    reach += 2 * step;
  }
  std::ranges::sort(shots, by_position);
  return true;
}

GateScan as_gate(BenchScan&& scan) {
  return {scan.width_px, scan.n_lines, scan.sensor_lines, std::move(scan.light),
          scan.context.exposure_us};
}

// Metered, then at fractions of that: all channels together for noise and linearity, each alone for
// light that shows in another.
bool scan_gate(Scanner& scanner, const ScanRequest& base, Work& work, std::vector<GateScan>& out) {
  ScanRequest request = base;
  request.focus.mode = FocusRequest::Mode::kKeep;
  const ScanPlan whole = plan_of(scanner, request, work.reporter, false);
  const double mm_y = kMmPerInch / whole.format.y_dpi;
  const int lines = std::min(kGateLines, whole.format.n_lines);
  request.area.top_mm = base.area.top_mm.value_or(0) + 0.5 * (whole.format.n_lines - lines) * mm_y;
  request.area.height_mm = lines * mm_y;
  auto scan = scan_to_memory(scanner, plan_of(scanner, request, work.reporter, false), work);
  if (!scan) return false;
  const std::array<std::optional<double>, 4> metered = scan->context.exposure_us;
  const bool known = std::all_of(metered.begin(), metered.begin() + 3,
                                 [](const auto& us) { return us.has_value(); });
  out.push_back(as_gate(std::move(*scan)));
  if (!known) {
    work.reporter.note("The scanner does not say its exposures; the open frame is scanned once.");
    return true;
  }
  std::vector<std::array<double, 4>> factors{{0.7, 0.7, 0.7, 0.7},     {0.5, 0.5, 0.5, 0.5},
                                             {0.25, 0.25, 0.25, 0.25}, {0.125, 0.125, 0.125, 0.125},
                                             {0.06, 0.06, 0.06, 0.06}, {0.3, 1, 1, 1},
                                             {1, 0.3, 1, 1},           {1, 1, 0.3, 1}};
  if (metered[3]) factors.push_back({1, 1, 1, 0.3});
  const double least = scanner.capabilities().exposure_min_us;
  for (const auto& factor : factors) {
    request.exposure.mode = ExposureRequest::Mode::kFixed;
    bool possible = true;
    for (std::size_t c = 0; c < metered.size(); ++c) {
      if (!metered[c]) continue;
      request.exposure.exposure_us[c] = *metered[c] * factor[c];
      possible = possible && *metered[c] * factor[c] >= least;
    }
    if (!possible) continue;
    auto next = scan_to_memory(scanner, plan_of(scanner, request, work.reporter, false), work);
    if (!next) return false;
    out.push_back(as_gate(std::move(*next)));
  }
  return true;
}

// The middle of the frame, where the target lies, at most kRandom_mm a side.
bool scan_random(Scanner& scanner, const ScanRequest& base, const std::string& device,
                 const std::filesystem::path& path, Work& work) {
  ScanRequest request = base;
  request.area = {};
  const ScanPlan whole = plan_of(scanner, request, work.reporter, false);
  const double width_mm = whole.format.width_px * kMmPerInch / whole.format.x_dpi;
  const double height_mm = whole.format.n_lines * kMmPerInch / whole.format.y_dpi;
  const double across = std::min(kRandom_mm, width_mm), down = std::min(kRandom_mm, height_mm);
  request.area = {0.5 * (width_mm - across), 0.5 * (height_mm - down), across, down};
  return scan_to_file(scanner, plan_of(scanner, request, work.reporter, false), device, path, work);
}

}  // namespace

void BenchChoice::add_to(CLI::App& app) {
  scan.add_to(app);
  app.add_flag("--yes", yes, "Ask nothing: the edge target lies in the scanner, or it is simulated")
      ->group("Bench");
  app.add_option("-o,--output", output, "Folder for the scan of the edges and the report")
      ->group("Bench");
  app.add_flag("--no-focus", skip_focus, "No scans at other focus settings")->group("Bench");
  app.add_flag("--no-gate", skip_gate, "No scans of an open frame")->group("Bench");
  app.add_flag("--with-random", with_random,
               "Scan the random target of --target too, for the spread of a point")
      ->group("Bench");
  app.add_option("--focus-positions", focus_positions, "Focus settings around the best (9)")
      ->check(CLI::Range(3, 101))
      ->group("Bench");
  app.add_option("--focus-step", focus_step, "Steps of the unit from one to the next (10)")
      ->check(CLI::Range(1, 10000))
      ->group("Bench");
}

std::optional<BenchWork> run_bench(const BenchChoice& choice, const MeasureChoice& measure,
                                   Work& work) {
  Reporter& reporter = work.reporter;
  const ScanRequest base =
      as_failure(Doing::kReadingOptions, [&] { return choice.scan.request(); });
  const std::string named =
      as_failure(Doing::kReadingOptions, [&] { return choose_device(choice.scan.device); });
  BenchWork out;
  out.device = device_with(named, "razor", false);
  const PreparedDirectory prepared{std::filesystem::path(choice.output)};

  if (!ask("1. Lay the edge target (a razor blade, a slit) into the holder, its edge slanted by "
           "three to ten degrees, and put the holder in.",
           choice.yes, work)) {
    return std::nullopt;
  }
  std::unique_ptr<Scanner> scanner = open_with(out.device, reporter);
  const ScanPlan plan = plan_of(*scanner, base, reporter, true);
  reporter.say(plan_line(plan, choice.output));
  {
    const NameReservation name = as_failure(Doing::kWriting, [&] {
      return reserve_numbered(choice.output, "calibration_" + utc_now(false).substr(0, 10));
    });
    out.edge_file = name.path(".tif");
    if (!scan_to_file(*scanner, plan, out.device, out.edge_file, work)) return std::nullopt;
  }
  MeasureChoice all = measure;
  all.most_edges = std::max(measure.most_edges, kMostEdges);
  out.edges =
      as_failure(Doing::kReadingInput, [&] { return measure_file(out.edge_file, all, reporter); });

  const MeasuredEdge* best = edge_for_focus(out.edges);
  const Capabilities& able = scanner->capabilities();
  if (best != nullptr && !choice.skip_focus && able.focus_max > able.focus_min) {
    reporter.say("2. The same edge at other focus settings.");
    ScanRequest near = base;
    near.area = area_of(base, plan, best->roi);
    const int middle =
        out.edges.context.focus_position.value_or((able.focus_min + able.focus_max) / 2);
    if (!sweep_focus(*scanner, choice, near, middle, measure.window_px, work, out.focus)) {
      return std::nullopt;
    }
  }
  int step = 3;
  if (choice.with_random) {
    scanner.reset();
    if (!ask(fmt::format("{}. Lay the random target into the middle of the holder, instead.",
                         step++),
             choice.yes, work)) {
      return std::nullopt;
    }
    out.random_file = std::filesystem::path(out.edge_file).replace_extension(".random.tif");
    refuse_existing(out.random_file);
    const std::string device = device_with(named, "random", true);
    scanner = open_with(device, reporter);
    if (!scan_random(*scanner, base, device, out.random_file, work)) return std::nullopt;
  }
  if (!choice.skip_gate) {
    scanner.reset();
    if (!ask(fmt::format(
                 "{}. Take the target out, so that nothing but the open holder is in the light.",
                 step),
             choice.yes, work)) {
      return std::nullopt;
    }
    scanner = open_with(device_with(named, "clear", true), reporter);
    ScanRequest open = base;
    open.area.top_mm = base.area.top_mm;
    if (!scan_gate(*scanner, open, work, out.gate)) return std::nullopt;
  }
  return out;
}

}  // namespace reseau::cli
