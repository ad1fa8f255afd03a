#include "core/screen/follow_screen.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <Eigen/Dense>

#include "core/base/parallel.h"
#include "core/screen/element_model.h"
#include "core/screen/line_fit.h"
#include "core/screen/line_hypothesis.h"
#include "core/screen/live_map.h"
#include "core/screen/phase_samples.h"
#include "core/screen/phase_window.h"
#include "core/screen/sample_grower.h"
#include "core/screen/spline_surface.h"

namespace reseau {
namespace {

// Splines as coarse as this may take what a bent film does before the lines are looked at.
constexpr double kBeforeLinesPx = 330;
constexpr double kFlatPx = 0.012;
// To start from, a flat map that leaves no more than this is as good as one that bends.
constexpr double kStartPx = 0.05;
// What blocks of large cells leave of a film that bends within them [px].
constexpr double kSharpBendPx = 0.15;
// A fit this much better than another is worth another look for lines.
constexpr double kBetterFit = 0.9;
// A map that moves by less than this, rms, from one round to the next is not measured again [px].
constexpr double kSettledPx = 0.001;
// A block that lies farther from a map than this does not vouch for it [periods].
constexpr double kAgreed = 0.2;

// Variance of the blur that explains the amplitudes of a series best, a step of 0.05 px in its root
// [px^2].
double pattern_blur_px2(const ColorSeries& series, const ScreenMap& map, ScreenLayout layout) {
  // As many amplitudes as the series has; the rest of the model's are not measured here.
  constexpr int kKnown = 1 + kSeries;
  const ElementModel model(map.linear(), layout);
  const auto misfit = [&](double sigma_px) {
    const Eigen::Matrix<double, kKnown, 3> columns = model.columns(sigma_px).topRows<kKnown>();
    const auto solver = columns.colPivHouseholderQr();
    double sum = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      Eigen::Matrix<double, kKnown, 1> seen;
      seen(0) = series.mean[c];
      for (int i = 0; i < kSeries; ++i) {
        seen(i + 1) = std::numbers::sqrt2 * series.harmonic[c][static_cast<std::size_t>(i)].real();
      }
      sum += (seen - columns * solver.solve(seen)).squaredNorm() / seen.squaredNorm();
    }
    return sum;
  };
  constexpr double kLeast = 0.25, kMost = 3.5, kStep = 0.05;
  double best = kLeast;
  for (double sigma = kLeast; sigma < kMost; sigma += kStep) {
    if (misfit(sigma) < misfit(best)) best = sigma;
  }
  return best * best;
}

// What strips of a few lines say about the error of the line under the smooth part of a map.
std::vector<LineSample> line_samples(const std::vector<PhaseSample>& strips, const ScreenMap& map) {
  const ScreenMap smooth = map.without_line_error();
  std::vector<LineSample> samples;
  samples.reserve(strips.size());
  for (const PhaseSample& strip : strips) {
    const Mat2 to_px = smooth.jacobian(strip.p_in_scan).inverse();
    const Vec2 off = strip.s_in_screen - smooth.screen_from_scan(strip.p_in_scan);
    // Variances of the two screen coordinates, carried to the scan's.
    const double var_u = 1 / std::max(strip.info_u, 1e-12),
                 var_v = 1 / std::max(strip.info_v, 1e-12);
    const double var_x = to_px.a * to_px.a * var_u + to_px.b * to_px.b * var_v;
    const double var_y = to_px.c * to_px.c * var_u + to_px.d * to_px.d * var_v;
    samples.push_back({strip.p_in_scan, to_px * off, 1 / var_x, 1 / var_y});
  }
  return samples;
}

// The blocks of the largest part of a grid that hangs together: of those that are set and of whose
// four neighbours three are, and those beside them.
std::vector<bool> largest_part(const std::vector<bool>& set, int n_columns) {
  const int n = static_cast<int>(set.size()), n_rows = n / n_columns;
  const auto neighbours = [&](int at, const auto& visit) {
    const int i = at % n_columns, j = at / n_columns;
    if (i > 0) visit(at - 1);
    if (i + 1 < n_columns) visit(at + 1);
    if (j > 0) visit(at - n_columns);
    if (j + 1 < n_rows) visit(at + n_columns);
  };
  std::vector<int> part(set.size(), 0);  // 0: not looked at
  const auto inner = [&](int at) {
    int missing = 0;
    neighbours(at, [&](int q) { missing += set[static_cast<std::size_t>(q)] ? 0 : 1; });
    return set[static_cast<std::size_t>(at)] && missing <= 1;
  };
  int largest = 0, n_parts = 0;
  std::size_t most = 0;
  for (int start = 0; start < n; ++start) {
    if (part[static_cast<std::size_t>(start)] != 0 || !inner(start)) continue;
    std::vector<int> open{start};
    part[static_cast<std::size_t>(start)] = ++n_parts;
    for (std::size_t k = 0; k < open.size(); ++k) {
      neighbours(open[k], [&](int q) {
        if (part[static_cast<std::size_t>(q)] != 0 || !inner(q)) return;
        part[static_cast<std::size_t>(q)] = n_parts;
        open.push_back(q);
      });
    }
    if (open.size() > most) {
      most = open.size();
      largest = n_parts;
    }
  }
  std::vector<bool> kept(set.size(), false);
  for (int at = 0; at < n; ++at) {
    const auto k = static_cast<std::size_t>(at);
    kept[k] = most > 0 && part[k] == largest;
    if (kept[k] || !set[k] || part[k] != 0) continue;
    neighbours(at, [&](int q) {
      kept[k] = kept[k] || (most > 0 && part[static_cast<std::size_t>(q)] == largest);
    });
  }
  return kept;
}

class Follower {
 public:
  Follower(const CellGrid& cells, const LatticeSeed& seed)
      : cells_(cells), seed_(seed), drift_(cells, seed) {
    const double period = std::max(1 / norm(seed.carriers.u), 1 / norm(seed.carriers.v));
    small_ = cells.size().width < 16;
    block_ = block_of_four_periods(cells, seed.carriers);
    const int side_px = block_.rows * cells.size().lines;
    const double area = static_cast<double>(cells.width_px()) * cells.height_px();
    finest_px_ = small_ ? 20 : std::max(area > 20e6 ? 64.0 : 40.0, 1.25 * side_px);
    // At least four strips across, or none could vouch for the others.
    const auto strip_cells = [&](int extent_px, int cell_px) {
      return std::clamp(extent_px / 4 / cell_px / 2 * 2, std::max(2, 64 / cell_px), 256 / cell_px);
    };
    // And two periods high, unless one fits a cell: less, where the lines of a réseau run along the
    // scan's, shows the cut through the pattern and not the stage.
    const auto cells_of_two_periods = [&](int cell_px) {
      return period <= cell_px ? 1 : static_cast<int>(std::ceil(2 * period / cell_px));
    };
    strip_ = {strip_cells(cells.width_px(), cells.size().width * cells.keep_every()),
              cells_of_two_periods(cells.size().lines), 0};
    tall_strip_ = {cells_of_two_periods(cells.size().width),
                   strip_cells(cells.height_px(), cells.size().lines), 0};
  }

  FollowedScreen grow(bool check_left_out) {
    FollowedScreen result;
    series_ = series_from_response(seed_.response, seed_.layout, seed_.special_color,
                                   seed_.carriers, seed_.sigma_px);
    const BlockShape growing = small_ ? small_blocks(8 / cells_.size().lines) : block_;
    SampleGrower grower(cells_, series_, growing);
    grower.start(seed_);
    grower.grow(grower.n_block_rows());
    const std::vector<PhaseSample> samples = grower.samples();
    result.coverage = coverage(samples.size(), growing);
    result.cell_px = cells_.size().width;
    result.fit = fit_map(samples, cells_.width_px(), cells_.height_px(), finest_px_, kStartPx,
                         {.n_choices = 1});
    const MapFit& fit = result.fit;
    result.needs_smaller_cells =
        !small_ && (!fit.usable || result.coverage < 0.7 || fit.residual_px > kSharpBendPx);
    if (fit.usable) improve(result, small_ ? 1 : 3, check_left_out && !small_);
    return result;
  }

  // Along the map so far. Then asks which blocks agree with it. A place that is off by whole
  // periods agrees as well, but is cut off from the rest by places that are off by half of one:
  // what does not hang together with the most of the film is not trusted. What lies beside trusted
  // blocks is then predicted well enough to be measured in the next pass.
  void go_along(FollowedScreen& result, bool check_left_out) {
    if (!refresh_series(screen_at_cells(cells_, result.fit.map), result.fit.map)) return;
    if (result.trusted.empty()) improve(result, 1, false);
    const auto n_before = std::ranges::count(result.trusted, true);
    SampleGrower blocks(cells_, series_, small_blocks(1));
    blocks.measure_all(result.fit.map, kAgreed);
    result.trusted = largest_part(blocks.accepted(), blocks.n_block_columns());
    const auto n_trusted = std::ranges::count(result.trusted, true);
    improve(result, 1, check_left_out);
    result.settled = n_trusted <= n_before;
  }

  // From a usable map to a better one.
  void improve(FollowedScreen& result, int n_rounds, bool check_left_out) {
    MapFit fit = result.fit;
    double looked_at_px = 1e9;  // what a map left when lines were last looked for
    bool line_is_new = true;
    for (int round = 0; round < n_rounds; ++round) {
      const std::vector<Vec2> screen = screen_at_cells(cells_, fit.map);
      if (!refresh_series(screen, fit.map)) break;
      std::vector<PhaseSample> samples =
          measure_samples(cells_, fit.map, screen, series_, block_, drift_, blur_px2_);
      std::erase_if(samples, [&](const auto& sample) { return !trusts(result, sample.p_in_scan); });
      const LineError line = fit.map.line_error();
      MapFit better = fit_smooth(samples, finest_px_, plan_after(fit, line_is_new));
      line_is_new = false;
      // Few samples may not prove again what was proven: film that bends within a tile does not
      // turn flat from one look to the next.
      if (small_ && !fit.levels.flat() && better.residual_px > 2 * fit.residual_px)
        better = fit_smooth(samples, finest_px_, {&fit.levels, 0});
      if (!better.usable) break;
      better.map = better.map.with_line_error(line);
      // Nor do its bends pass for a stage where splines follow them.
      const bool bends = small_ && better.residual_px < kSharpBendPx && !better.map.is_affine();
      const bool fits = better.map.is_affine() && better.residual_px <= flat_px();
      // Where none was found a better fit of the film may show one.
      const bool worth_a_look = !line.none() || better.residual_px < kBetterFit * looked_at_px;
      if (!bends && !fits && worth_a_look) {
        looked_at_px = better.residual_px;
        const LineFit found = look_for_lines(fit.map, screen, samples, better.map);
        if (!found.error.none()) {
          result.line_gain = std::max(result.line_gain, found.gain);
          if (line.none()) {
            // The film anew, now that the stage is known.
            better = fit_smooth(samples, kBeforeLinesPx);
            line_is_new = true;
          }
          better.map = better.map.with_line_error(found.error);
        }
      }
      const bool settled =
          better.map.is_affine() ||
          (line.none() && !line_is_new && moved_px(samples, fit.map, better.map) < kSettledPx);
      fit = better;
      if (settled && round >= 1) break;
    }
    result.fit = fit;
    if (check_left_out) result.left_out_px = left_out(fit.map);
  }

 private:
  // Blocks of 8 x 8 px that see some cells beyond their borders.
  [[nodiscard]] BlockShape small_blocks(int reach) const {
    return {8 / cells_.size().width, 8 / cells_.size().lines, reach};
  }
  // Whether most of the blocks about a place are trusted.
  [[nodiscard]] bool trusts(const FollowedScreen& result, Vec2 p) const {
    if (result.trusted.empty()) return true;
    const BlockShape shape = small_blocks(0);
    const BlockGrid grid(cells_, shape);
    const double width = shape.columns * cells_.size().width,
                 lines = shape.rows * cells_.size().lines;
    int n = 0;
    for (const double dy : {-0.5, 0.5}) {
      for (const double dx : {-0.5, 0.5}) {
        const int i = std::clamp(static_cast<int>(std::floor(p.x / width + dx)), 0, grid.nx - 1);
        const int j = std::clamp(static_cast<int>(std::floor(p.y / lines + dy)), 0, grid.ny - 1);
        const auto at = static_cast<std::size_t>(j) * static_cast<std::size_t>(grid.nx) +
                        static_cast<std::size_t>(i);
        n += result.trusted[at] ? 1 : 0;
      }
    }
    return n >= 1;
  }

  // Film and stage fitted anew without a fifth of the blocks, for two of the fifths.
  [[nodiscard]] std::optional<Vec2> left_out(const ScreenMap& map) const {
    const std::vector<Vec2> screen = screen_at_cells(cells_, map);
    const std::vector<PhaseSample> all =
        measure_samples(cells_, map, screen, series_, block_, drift_, blur_px2_);
    const LineError& known = map.line_error();
    const double block_px = left_out_block_px(finest_px_);
    std::vector<PhaseSample> strips;
    if (!known.none()) {
      strips = measure_samples(cells_, map, screen, series_,
                               known.axis == LineError::Axis::kLines ? strip_ : tall_strip_, drift_,
                               blur_px2_);
    }
    std::vector<double> off_u, off_v;
    for (const int fold : {0, 2}) {
      std::vector<PhaseSample> seen;
      for (const PhaseSample& sample : all) {
        if (!left_out_of_fold(sample.p_in_scan, fold, block_px)) seen.push_back(sample);
      }
      const MapFit film = fit_smooth(seen, finest_px_, {.n_choices = 1});
      if (!film.usable) return std::nullopt;
      LineError line = known;
      if (!known.none()) {
        std::vector<LineSample> lines;
        for (LineSample& strip : line_samples(strips, film.map)) {
          if (left_out_of_fold(strip.p_in_scan, fold, block_px)) continue;
          strip.off_px = strip.off_px + known.at(strip.p_in_scan);
          lines.push_back(strip);
        }
        line.coefficients.assign(line.coefficients.size(), Vec2{});
        line = improve_line_error(lines, line);
      }
      for (const PhaseSample& sample : all) {
        const Vec2 p = sample.p_in_scan;
        if (!left_out_of_fold(p, fold, block_px)) continue;
        const Vec2 ideal = p + (line.at(p) - known.at(p));
        const Vec2 off = sample.s_in_screen - film.map.smooth_screen_from_scan(ideal);
        // Of lines alone u is not measured.
        off_u.push_back(cells_.carriers().lines ? 0 : std::abs(off.x) / norm(cells_.carriers().u));
        off_v.push_back(std::abs(off.y) / norm(cells_.carriers().v));
      }
    }
    if (off_u.size() < 8) return std::nullopt;
    // Blocks that went astray count as outliers: beyond five times the middle one.
    const auto rms = [](std::vector<double> sizes) {
      std::ranges::sort(sizes);
      const double most = 5 * 1.4826 * sizes[sizes.size() / 2];
      double sum = 0, n = 0;
      for (const double size : sizes) {
        if (size > most) break;
        sum += size * size;
        n += 1;
      }
      return std::sqrt(sum / n);
    };
    return Vec2{rms(off_u), rms(off_v)};
  }

  [[nodiscard]] MapFit fit_smooth(const std::vector<PhaseSample>& samples, double finest,
                                  const LevelPlan& plan = {}) const {
    return fit_map(samples, cells_.width_px(), cells_.height_px(), finest, flat_px(), plan);
  }

  // Bends that were proven in a round are not proven anew in the next, as long as the stage is seen
  // alike. That there are none is.
  [[nodiscard]] LevelPlan plan_after(const MapFit& fit, bool line_is_new) const {
    const SurfaceLevels all = surface_levels(cells_.width_px(), cells_.height_px(), finest_px_);
    if (fit.levels.flat() || fit.levels.spacing_px != all.spacing_px) return {};
    return {&fit.levels, line_is_new ? 1 : 0};
  }

  // Between two maps, rms over the places of samples.
  static double moved_px(const std::vector<PhaseSample>& samples, const ScreenMap& from,
                         const ScreenMap& to) {
    double sum = 0;
    const Mat2 px_of_periods = from.linear().inverse();
    for (const PhaseSample& sample : samples) {
      const Vec2 p = sample.p_in_scan;
      const Vec2 px =
          px_of_periods * (to.smooth_screen_from_scan(p) - from.smooth_screen_from_scan(p));
      sum += dot(px, px);
    }
    return std::sqrt(sum / std::max(1.0, static_cast<double>(samples.size())));
  }

  // A map that leaves no more than this needs neither lines nor splines: what the picture does to
  // the phases grows with the blur.
  [[nodiscard]] double flat_px() const { return kFlatPx + 0.005 * blur_px2_; }

  [[nodiscard]] double coverage(std::size_t n_samples, const BlockShape& shape) const {
    double most = 0;
    for (int r = 0; r < cells_.n_rows(); ++r) {
      for (int c = 0; c < cells_.n_columns(); ++c) most = std::max(most, cells_.light(c, r));
    }
    double lit = 0;
    for (int r = 0; r < cells_.n_rows(); ++r) {
      for (int c = 0; c < cells_.n_columns(); ++c) lit += cells_.light(c, r) > 1e-3 * most ? 1 : 0;
    }
    return std::min(
        1.0, static_cast<double>(n_samples) * shape.columns * shape.rows / std::max(lit, 1.0));
  }

  bool refresh_series(const std::vector<Vec2>& screen, const ScreenMap& map) {
    ColorSeries fresh;
    if (!pooled_series(cells_, screen, fresh)) return false;
    if (fresh.lines) {
      blur_px2_ = settle_lines(fresh, 1 / norm(cells_.carriers().v));
      series_ = fresh;
      return true;
    }
    // The pattern is even about its origin: an odd part is the error of the origin so far, which
    // the next round is to find, not to keep.
    for (auto& channel : fresh.harmonic) {
      for (auto& value : channel) value = value.real();
    }
    series_ = fresh;
    blur_px2_ = pattern_blur_px2(series_, map, seed_.layout);
    return true;
  }

  [[nodiscard]] double strip_length_px(LineError::Axis axis) const {
    return axis == LineError::Axis::kLines
               ? static_cast<double>(strip_.columns) * cells_.keep_every() * cells_.size().width
               : static_cast<double>(tall_strip_.rows) * cells_.size().lines;
  }

  // An error of the line under the film as coarse splines describe it, or more of the error that is
  // known already.
  [[nodiscard]] LineFit look_for_lines(const ScreenMap& seen_under, const std::vector<Vec2>& screen,
                                       const std::vector<PhaseSample>& samples,
                                       const ScreenMap& better) const {
    LineFit result;
    const LineError& known = better.line_error();
    const auto strips_along = [&](LineError::Axis axis) {
      const bool lines = axis == LineError::Axis::kLines;
      std::vector<PhaseSample> strips = measure_samples(
          cells_, seen_under, screen, series_, lines ? strip_ : tall_strip_, drift_, blur_px2_);
      // One that the border of the frame cuts errs alike all along it, as only a stage does.
      const double half = 0.5 * thickness_px(axis),
                   extent = lines ? cells_.height_px() : cells_.width_px();
      std::erase_if(strips, [&](const PhaseSample& strip) {
        return (lines ? strip.p_in_scan.y : strip.p_in_scan.x) + half > extent;
      });
      return strips;
    };
    if (!known.none()) {
      result.error = improve_line_error(line_samples(strips_along(known.axis), better), known);
      return result;
    }
    const MapFit coarse = fit_smooth(samples, kBeforeLinesPx, {.n_choices = 1});
    if (!coarse.usable) return result;
    for (const LineError::Axis axis : {LineError::Axis::kLines, LineError::Axis::kColumns}) {
      const bool lines = axis == LineError::Axis::kLines;
      const LineFit found =
          fit_line_error(line_samples(strips_along(axis), coarse.map), axis, strip_length_px(axis),
                         lines ? cells_.height_px() : cells_.width_px(), thickness_px(axis));
      if (!found.error.none() && found.gain > result.gain) result = found;
    }
    return result;
  }

  // Of a strip, along which the error of the stage changes.
  [[nodiscard]] int thickness_px(LineError::Axis axis) const {
    return axis == LineError::Axis::kLines ? strip_.rows * cells_.size().lines
                                           : tall_strip_.columns * cells_.size().width;
  }

  const CellGrid& cells_;
  const LatticeSeed& seed_;
  LightDrift drift_;
  bool small_ = false;
  BlockShape block_, strip_, tall_strip_;
  double finest_px_ = 40;
  ColorSeries series_;
  double blur_px2_ = 0.36;
};

}  // namespace

FollowedScreen follow_screen(const CellGrid& cells, const LatticeSeed& seed, bool check_left_out) {
  return Follower(cells, seed).grow(check_left_out);
}

FollowedScreen follow_along(const CellGrid& cells, const LatticeSeed& seed,
                            const FollowedScreen& known, bool check_left_out) {
  FollowedScreen result = known;
  Follower(cells, seed).go_along(result, check_left_out);
  return result;
}

int keep_every_for(int width_px, int height_px, bool exact) {
  const double megapixels = static_cast<double>(width_px) * height_px * 1e-6;
  return exact ? 1 : std::max(1, static_cast<int>(std::lround(megapixels / 10)));
}

}  // namespace reseau
