#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/reconstruct/reconstruct.h"
#include "core/screen/cell_moments.h"
#include "core/screen/follow_screen.h"
#include "core/screen/lattice_search.h"
#include "core/screen/linear_rows.h"
#include "core/screen/screen_layout.h"

namespace reseau {
namespace {

// A map that leaves more than this has lost its way [px].
constexpr double kLargestResidualPx = 0.4;
constexpr int kSearchRows = 512;  // a réseau is looked for in blocks of so many lines
constexpr int kTaskRows = 32;     // a multiple of the lines of a cell

// The plane that fits the map best over the whole frame: a stage that wobbles bends the slope at
// any one place by more than the lattice is wrong on the whole.
Mat2 mean_linear(const ScreenMap& map, int width_px, int height_px) {
  constexpr int kSteps = 32;
  Vec2 sum_x, sum_y;
  double norm_x = 0, norm_y = 0;
  for (int j = 0; j <= kSteps; ++j) {
    for (int i = 0; i <= kSteps; ++i) {
      const double x = (static_cast<double>(i) / kSteps - 0.5) * (width_px - 1);
      const double y = (static_cast<double>(j) / kSteps - 0.5) * (height_px - 1);
      const Vec2 s = map.screen_from_scan({x + (width_px - 1) / 2.0, y + (height_px - 1) / 2.0});
      sum_x = sum_x + x * s;
      sum_y = sum_y + y * s;
      norm_x += x * x;
      norm_y += y * y;
    }
  }
  return {sum_x.x / norm_x, sum_y.x / norm_y, sum_x.y / norm_x, sum_y.y / norm_y};
}

// Whether a map folds, or stretches the film threefold somewhere: then it is lost there.
bool folds(const ScreenMap& map, const Mat2& mean, int width_px, int height_px) {
  constexpr int kSteps = 64;
  for (int j = 0; j <= kSteps; ++j) {
    for (int i = 0; i <= kSteps; ++i) {
      const Vec2 p{(width_px - 1.0) * i / kSteps, (height_px - 1.0) * j / kSteps};
      const double area = map.jacobian(p).determinant() / mean.determinant();
      if (!(area > 1.0 / 3 && area < 3)) return true;
    }
  }
  return false;
}

class Tracker {
 public:
  Tracker(const LineSource& source, const RegisterOptions& options, const ProgressFn& progress,
          const std::stop_token& stop)
      : source_(source), options_(options), progress_(progress), stop_(stop) {}

  Registration run() {
    const LineFormat& format = source_.format();
    const int height = format.n_lines;
    int next_search = 0;
    std::string reason = "No réseau was found: the picture is empty.";
    // Search block by block as lines arrive. A seed that leads nowhere is given up for the next.
    while (next_search < height) {
      int end = std::min(height, next_search + kSearchRows);
      if (height - end < kSearchRows / 2) end = height;
      const int have = source_.wait_committed(end, stop_);
      if (stop_.stop_requested()) return stopped();
      // The scan ended early: what there is, is all there is.
      if (have < end) end = have;
      if (end - next_search < 16) break;
      const int first = next_search, n = end - next_search;
      next_search = have < end ? height : end;
      // Film that bends within a large tile shows itself to small ones, and plainly.
      for (const int tile_px : {kLargestTilePx, kSmallestTilePx}) {
        const std::optional<LatticeSeed> seed = search(first, n, tile_px, reason);
        if (!seed) break;
        if (tile_px == kSmallestTilePx && (seed->explained < 0.5 || seed->foreign > 0.3)) break;
        Registration result = track(*seed, tile_px == kSmallestTilePx);
        if (result.found || stop_.stop_requested()) return result;
        reason = result.reason;
        keep_evidence(result.confidence, *seed);
      }
      if (source_.committed() <= next_search) break;
    }
    Registration none = best_none_;
    none.screen = "none";
    none.reason = reason;
    return none;
  }

 private:
  static Registration stopped() {
    Registration result;
    result.screen = "none";
    result.reason = "Registration was stopped before the last line.";
    return result;
  }

  // Finds a seed in a block of lines; without infrared also the weights that make silver of RGB.
  std::optional<LatticeSeed> search(int first, int n, int tile_px, std::string& reason) {
    LinearReader reader(source_, options_.tone);
    LinearRows rows;
    reader.read(first, n, rows);
    const LatticeSearch found = find_lattice(rows, reader.has_infrared(), tile_px);
    if (!found.found) {
      reason = found.reason;
      keep_evidence(0.5 * found.seed.confidence * found.seed.explained, found.seed);
      return std::nullopt;
    }
    if (!silver_weights(found.seed.response, weights_)) {
      reason =
          "No réseau was found: a repeating pattern is there, but its elements cannot be told "
          "apart by colour.";
      return std::nullopt;
    }
    return found.seed;
  }

  // What came nearest to a réseau where none was found.
  void keep_evidence(double confidence, const LatticeSeed& seed) {
    const double screen = std::clamp(confidence, 0.0, 0.49);
    if (!(screen > best_none_.runner_up_probability)) return;
    best_none_.runner_up =
        name_screen({seed.layout, seed.special_color, seed.explained, seed.other_explained, 0})
            .front()
            .name;
    best_none_.runner_up_probability = screen;
    best_none_.none_probability = best_none_.screen_probability = 1 - screen;
    best_none_.explained = seed.explained;
  }

  Registration track(const LatticeSeed& seed, bool bends) {
    const LineFormat& format = source_.format();
    CellGrid cells(format.width_px, format.n_lines, seed.carriers,
                   bends ? CellSize{8, 8} : CellSize{},
                   bends ? 1 : keep_every_for(format.width_px, format.n_lines, false));
    int done = 0;
    while (done < format.n_lines) {
      const int want = std::min(format.n_lines, done + kTaskRows);
      int have = source_.wait_committed(want, stop_);
      if (stop_.stop_requested()) return stopped();
      const bool ended = have < want;
      // Whole bands only, but for the end of the frame.
      int end = have == format.n_lines || ended ? have : have / kTaskRows * kTaskRows;
      end = std::min(end, done + 64 * kTaskRows);
      if (ended) end = have / kTaskRows * kTaskRows;
      if (end > done) accumulate(cells, done, end);
      done = std::max(done, end);
      if (progress_) progress_(0.9 * done / format.n_lines);
      if (ended) break;
    }
    return finish(seed, cells);
  }

  void accumulate(CellGrid& cells, int begin, int end) {
    const int n_tasks = (end - begin + kTaskRows - 1) / kTaskRows;
    parallel_for(n_tasks, [&](int task) {
      LinearReader reader(source_, options_.tone);
      reader.set_silver_from_rgb(weights_);
      LinearRows rows;
      const int first = begin + task * kTaskRows;
      reader.read(first, std::min(kTaskRows, end - first), rows);
      cells.accumulate(rows);
    });
  }

  Registration finish(const LatticeSeed& seed, const CellGrid& cells) {
    Registration result;
    result.screen = "none";
    FollowedScreen followed = follow_screen(cells, seed, options_.check_left_out);
    if (followed.needs_smaller_cells) {
      CellGrid small(cells.width_px(), cells.height_px(), seed.carriers, CellSize{8, 8});
      accumulate(small, 0, source_.committed());
      FollowedScreen again = follow_screen(small, seed, options_.check_left_out);
      if (again.fit.usable && again.coverage > followed.coverage - 0.1 &&
          (!followed.fit.usable || again.fit.residual_px < followed.fit.residual_px ||
           again.coverage > followed.coverage + 0.1)) {
        followed = std::move(again);
      }
    }
    if (!followed.fit.usable) {
      result.reason =
          "No réseau was found: a repeating pattern was seen in one place but could not be "
          "followed from there.";
      return result;
    }
    fill(result, seed, followed);
    return result;
  }

  void fill(Registration& result, const LatticeSeed& seed, const FollowedScreen& followed) const {
    const LineFormat& format = source_.format();
    const MapFit& fit = followed.fit;
    const double coverage = followed.coverage;
    result.map = fit.map;
    result.residual_px = fit.residual_px;
    result.n_windows = fit.n_used;
    result.n_outliers = fit.n_outliers;
    const Mat2 mean = mean_linear(fit.map, format.width_px, format.n_lines);
    result.lattice_cy_per_px = {Vec2{mean.a, mean.b}, Vec2{mean.c, mean.d}};
    result.period_px = {1 / norm(result.lattice_cy_per_px[0]),
                        1 / norm(result.lattice_cy_per_px[1])};
    // Red lines run along u: the direction in which v stays the same.
    Vec2 along{-mean.d, mean.c};
    if (along.y < 0) along = -1.0 * along;
    result.angle_deg = std::atan2(along.x, along.y) * 180 / std::numbers::pi;
    if (format.x_dpi > 0) {
      for (std::size_t i = 0; i < 2; ++i)
        result.period_um[i] = result.period_px[i] * 25400 / format.x_dpi;
    }
    result.uncertainty =
        MapUncertainty(fit.map, fit.placed, fit.error_model, format.width_px, format.n_lines);
    result.left_out_px = followed.left_out_px;
    fill_uncertainty(result, mean);
    result.explained = seed.explained;
    result.response = seed.response;
    result.silver_from_rgb = weights_;
    const double worst_period = std::min(result.period_px[0], result.period_px[1]);
    const double tightness = std::exp(-std::pow(fit.residual_px / (0.12 * worst_period), 2));
    result.confidence =
        (1 - doubt(seed)) * seed.confidence * tightness * (-std::expm1(-coverage / 0.15));
    result.found = result.confidence > 0.35 && fit.n_used >= 6 &&
                   fit.residual_px < kLargestResidualPx &&
                   !folds(fit.map, mean, format.width_px, format.n_lines);
    if (!result.found) result.confidence = std::min(result.confidence, 0.35);
    result.none_probability = 1 - std::min(result.confidence, 1 - 1e-6);
    if (result.found) {
      fill_names(result, seed);
    } else {
      result.reason =
          "No réseau was found: a weak repeating pattern is there, but it does not hold together "
          "over the picture.";
    }
  }

  // A lattice that explains little while something else repeats as plainly is a halftone, a fabric,
  // a texture. Simulated films, blurred, noisy or faded, show 0 to 0.5 of foreign power; pictures
  // without a réseau that got so far 0.95 and more, and at most 0.13 explained.
  static double doubt(const LatticeSeed& seed) {
    return 1 / (1 + std::exp(-12 * (seed.foreign - 0.75))) /
           (1 + std::exp(40 * (seed.explained - 0.2)));
  }

  static void fill_uncertainty(Registration& result, const Mat2& mean) {
    const Mat2& sd = result.uncertainty.slope_sd();
    // The length of a frequency along itself, and its direction.
    const auto along = [](Vec2 f, Vec2 s) { return std::hypot(f.x * s.x, f.y * s.y) / norm(f); };
    const auto across = [](Vec2 f, Vec2 s) { return std::hypot(f.y * s.x, f.x * s.y) / norm(f); };
    const Vec2 u{mean.a, mean.b}, v{mean.c, mean.d}, sd_u{sd.a, sd.b}, sd_v{sd.c, sd.d};
    result.period_sd_px = {along(u, sd_u) / dot(u, u), along(v, sd_v) / dot(v, v)};
    result.angle_sd_deg = across(v, sd_v) / norm(v) * 180 / std::numbers::pi;
  }

  static void fill_names(Registration& result, const LatticeSeed& seed) {
    const std::vector<ScreenGuess> guesses =
        name_screen({seed.layout, seed.special_color, seed.explained, seed.other_explained,
                     std::sqrt(result.period_um[0] * result.period_um[1])});
    const double some = 1 - result.none_probability;
    result.screen = guesses[0].name;
    result.screen_probability = some * guesses[0].probability;
    result.runner_up = guesses[1].name;
    result.runner_up_probability = some * guesses[1].probability;
    if (result.none_probability > result.runner_up_probability) {
      result.runner_up = "none";
      result.runner_up_probability = result.none_probability;
    }
  }

  const LineSource& source_;
  const RegisterOptions& options_;
  const ProgressFn& progress_;
  const std::stop_token& stop_;
  std::array<double, 3> weights_{1.0 / 3, 1.0 / 3, 1.0 / 3};
  Registration best_none_;
};

}  // namespace

Registration register_screen(const LineSource& source, const RegisterOptions& options,
                             const ProgressFn& progress, const std::stop_token& stop) {
  const LineFormat& format = source.format();
  for (const Channel channel : {Channel::kRed, Channel::kGreen, Channel::kBlue}) {
    if (format.plane_of(channel) < 0) {
      throw InputError(
          "The scan has no red, green and blue channels; a réseau cannot be told apart in it.");
    }
  }
  const auto start = std::chrono::steady_clock::now();
  Registration result;
  with_threads(options.n_threads, [&] { result = Tracker(source, options, progress, stop).run(); });
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (progress) progress(1.0);
  return result;
}

}  // namespace reseau
