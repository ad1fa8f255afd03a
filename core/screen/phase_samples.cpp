#include "core/screen/phase_samples.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/parallel.h"
#include "core/screen/phase_window.h"

namespace reseau {
namespace {

// A step of more than this from the prediction may be a neighbouring period.
constexpr double kLargestStep = 0.25;
// Error of a block in px per px^2 of blur, at light whose deviation from cell to cell is its mean.
constexpr double kSceneError = 0.03;
// And of the drift itself, which knows only slopes.
constexpr double kDriftError = 0.3;
// Error of a block, in px at such unevenness, that is cut along the pattern and holds one period.
constexpr double kCutError = 0.35;

// Mean of a wave over so many of its cycles, symmetric about a crest.
double mean_of_wave(double cycles) {
  const double a = std::numbers::pi * cycles;
  return std::abs(a) < 1e-6 ? 1 : std::sin(a) / a;
}

// Harmonics beyond those that are fitted, and light that is not even, speak where a block does not
// hold whole periods. Along a border that crosses the pattern this averages out, along one that
// follows it not.
double cut_px(const Window& window, Vec2 block_px, Vec2 frequency) {
  const double lit = window.sum / (window.n * window.most);
  const double periods_x = std::max(lit * block_px.x * norm(frequency), 0.5),
               periods_y = std::max(lit * block_px.y * norm(frequency), 0.5);
  const double below = std::abs(mean_of_wave(block_px.x * frequency.x)) / (periods_y * periods_y),
               beside = std::abs(mean_of_wave(block_px.y * frequency.y)) / (periods_x * periods_x);
  return kCutError * window.unevenness() * std::hypot(below, beside);
}

}  // namespace

bool make_sample(const Shift& shift, Vec2 p, Vec2 predicted, bool lines, PhaseSample& sample) {
  if (!(shift.modulation > 0.2 && shift.modulation < 4)) return false;
  if (!(std::abs(shift.delta.x) < kLargestStep && std::abs(shift.delta.y) < kLargestStep))
    return false;
  sample.p_in_scan = p;
  sample.s_in_screen = predicted + shift.delta;
  sample.info_u =
      shift.info_vv > 0 ? shift.info_uu - shift.info_uv * shift.info_uv / shift.info_vv : 0;
  sample.info_v =
      shift.info_uu > 0 ? shift.info_vv - shift.info_uv * shift.info_uv / shift.info_uu : 0;
  sample.modulation = shift.modulation;
  if (lines) {
    // Nothing is known of u: what was predicted holds, and every block believes it alike.
    sample.s_in_screen.x = predicted.x;
    sample.info_v = shift.info_vv;
    sample.info_u = sample.info_v;
  }
  sample.noise_info_u = sample.info_u;
  sample.noise_info_v = sample.info_v;
  return true;
}

std::vector<Vec2> screen_at_cells(const CellGrid& cells, const ScreenMap& map) {
  const auto n_columns = static_cast<std::size_t>(cells.n_columns());
  std::vector<Vec2> screen(n_columns * static_cast<std::size_t>(cells.n_rows()));
  if (map.is_affine()) {
    parallel_for(cells.n_rows(), [&](int r) {
      for (int c = 0; c < cells.n_columns(); ++c) {
        if (cells.kept(c))
          screen[static_cast<std::size_t>(r) * n_columns + static_cast<std::size_t>(c)] =
              map.screen_from_scan(cells.center(c, r));
      }
    });
    return screen;
  }
  // The mean over a cell of a map that bends: two thirds of its middle, a twelfth of each corner,
  // exact for cubics. Corners are shared with the cells beside and below.
  const Vec2 half{0.5 * cells.size().width, 0.5 * cells.size().lines};
  std::vector<Vec2> corners((n_columns + 1) * (static_cast<std::size_t>(cells.n_rows()) + 1));
  parallel_for(cells.n_rows() + 1, [&](int r) {
    for (int c = 0; c <= cells.n_columns(); ++c) {
      if (!cells.kept(c) && !cells.kept(c - 1)) continue;
      corners[static_cast<std::size_t>(r) * (n_columns + 1) + static_cast<std::size_t>(c)] =
          map.screen_from_scan(cells.center(c, r) - half);
    }
  });
  parallel_for(cells.n_rows(), [&](int r) {
    for (int c = 0; c < cells.n_columns(); ++c) {
      if (!cells.kept(c)) continue;
      const Vec2* above =
          &corners[static_cast<std::size_t>(r) * (n_columns + 1) + static_cast<std::size_t>(c)];
      const Vec2* below = above + n_columns + 1;
      screen[static_cast<std::size_t>(r) * n_columns + static_cast<std::size_t>(c)] =
          2.0 / 3 * map.screen_from_scan(cells.center(c, r)) +
          1.0 / 12 * (above[0] + above[1] + below[0] + below[1]);
    }
  });
  return screen;
}

std::vector<PhaseSample> measure_samples(const CellGrid& cells, const ScreenMap& map,
                                         const std::vector<Vec2>& screen, const ColorSeries& series,
                                         const BlockShape& shape, const LightDrift& drift,
                                         double blur_px2) {
  const BlockGrid grid(cells, shape);
  const auto n_columns = static_cast<std::size_t>(cells.n_columns());
  std::vector<std::vector<PhaseSample>> rows(static_cast<std::size_t>(grid.ny));
  parallel_for(grid.ny, [&](int j) {
    for (int i = 0; i < grid.nx; ++i) {
      const CellRange range = range_of(cells, shape, i, j, 0);
      const Window window = window_of(cells, range, [&](int c, int r, Vec2) {
        return screen[static_cast<std::size_t>(r) * n_columns + static_cast<std::size_t>(c)];
      });
      if (!(window.moments.n0 > 0)) continue;
      const Vec2 p = window.center;
      PhaseSample sample;
      if (!make_sample(fit_shift(window.moments, series), p, map.smooth_screen_from_scan(p),
                       cells.carriers().lines, sample))
        continue;
      const LightDrift::Slopes slopes = drift.of_block(range);
      const Mat2 jacobian = map.jacobian(p);
      sample.s_in_screen = sample.s_in_screen - blur_px2 * Vec2{(jacobian * slopes.for_u).x,
                                                                (jacobian * slopes.for_v).y};
      // What an edge in the picture does beyond that drift grows with the blur and the edge.
      const double drift_px = blur_px2 * std::max(norm(slopes.for_u), norm(slopes.for_v));
      const double scene_px =
          std::hypot(kSceneError * blur_px2 * window.unevenness(), kDriftError * drift_px);
      const Vec2 block_px{static_cast<double>((range.column1 - range.column0) * cells.size().width),
                          static_cast<double>((range.row1 - range.row0) * cells.size().lines)};
      const auto with_scene = [&](double info, Vec2 frequency) {
        const double px = std::hypot(scene_px, cut_px(window, block_px, frequency));
        return info > 0 ? 1 / (1 / info + px * px * dot(frequency, frequency)) : 0.0;
      };
      sample.info_u = with_scene(sample.info_u, cells.carriers().u);
      sample.info_v = with_scene(sample.info_v, cells.carriers().v);
      if (std::max(sample.info_u, sample.info_v) < kLeastInfo) continue;
      rows[static_cast<std::size_t>(j)].push_back(sample);
    }
  });
  std::vector<PhaseSample> samples;
  for (const auto& row : rows) samples.insert(samples.end(), row.begin(), row.end());
  return samples;
}

bool pooled_series(const CellGrid& cells, const std::vector<Vec2>& screen, ColorSeries& series) {
  const auto n_columns = static_cast<std::size_t>(cells.n_columns());
  std::vector<Moments> rows(static_cast<std::size_t>(cells.n_rows()));
  parallel_for(cells.n_rows(), [&](int r) {
    for (int c = 0; c < cells.n_columns(); ++c) {
      if (!(cells.light(c, r) > 0)) continue;
      const Vec2 s = screen[static_cast<std::size_t>(r) * n_columns + static_cast<std::size_t>(c)];
      add_rephased(rows[static_cast<std::size_t>(r)], cells.cell(c, r), cells.turn(c, r, s), 1);
    }
  });
  Moments total;
  for (const Moments& row : rows) add_rephased(total, row, {0, 0}, 1);
  series.lines = cells.carriers().lines;
  return fit_series(total, series);
}

}  // namespace reseau
