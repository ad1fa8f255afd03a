#include "core/screen/phase_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <queue>
#include <utility>

#include "core/base/parallel.h"

namespace reseau {
namespace {

// Surer than this, or a sample is not used at all [1/periods^2]: one sigma of 0.12 periods.
constexpr double kLeastInfo = 1 / (0.12 * 0.12);
// A step of more than this from the prediction may be a neighbouring period.
constexpr double kLargestStep = 0.25;
// Error of a block in px per px^2 of blur, at light whose deviation from cell to cell is its mean.
constexpr double kSceneError = 0.03;
// And of the drift itself, which knows only slopes.
constexpr double kDriftError = 0.3;
// Error of a block, in px at such unevenness, that is cut along the pattern and holds one period.
constexpr double kCutError = 0.35;

Vec2 carrier_phase(const Carriers& f, Vec2 p) { return {dot(f.u, p), dot(f.v, p)}; }

Mat2 carrier_matrix(const Carriers& f) { return {f.u.x, f.u.y, f.v.x, f.v.y}; }

CellRange range_of(const CellGrid& cells, const BlockShape& shape, int i, int j, int reach) {
  const int width = shape.columns * cells.keep_every();
  return {std::max(0, i * width - reach), std::min(cells.n_columns(), (i + 1) * width + reach),
          std::max(0, j * shape.rows - reach),
          std::min(cells.n_rows(), (j + 1) * shape.rows + reach)};
}

struct BlockGrid {
  int nx, ny;
  BlockGrid(const CellGrid& cells, const BlockShape& shape)
      : nx((cells.n_columns() + shape.columns * cells.keep_every() - 1) /
           (shape.columns * cells.keep_every())),
        ny((cells.n_rows() + shape.rows - 1) / shape.rows) {}
};

// The middle of the kept cells of a range.
Vec2 middle_of(const CellGrid& cells, const CellRange& range) {
  Vec2 sum;
  int n = 0;
  for (int c = range.column0; c < range.column1; ++c) {
    if (!cells.kept(c)) continue;
    sum = sum + cells.center(c, range.row0);
    ++n;
  }
  const double y0 = cells.center(0, range.row0).y, y1 = cells.center(0, range.row1 - 1).y;
  return {n > 0 ? sum.x / n : cells.center(range.column0, range.row0).x, 0.5 * (y0 + y1)};
}

// The sums of a block, its phases turned by `screen_at`, a prediction of screen coordinates.
struct Window {
  Moments moments;
  Vec2 center;                      // of the light
  double sum = 0, sum_squares = 0;  // of the light of its cells
  double most = 0;                  // of a cell
  int n = 0;

  // Standard deviation of the light of its cells over their mean.
  [[nodiscard]] double unevenness() const {
    if (n < 2 || !(sum > 0)) return 0;
    const double mean = sum / n;
    return std::sqrt(std::max(sum_squares / n - mean * mean, 0.0)) / mean;
  }
};

template <typename Predict>
Window window_of(const CellGrid& cells, const CellRange& range, const Predict& screen_at) {
  Window window;
  for (int r = range.row0; r < range.row1; ++r) {
    for (int c = range.column0; c < range.column1; ++c) {
      const double light = cells.light(c, r);
      if (!(light > 0)) continue;
      const Vec2 p = cells.center(c, r);
      add_rephased(window.moments, cells.cell(c, r),
                   screen_at(c, r, p) - carrier_phase(cells.carriers(), p), 1);
      window.center = window.center + light * p;
      window.sum += light;
      window.sum_squares += light * light;
      window.most = std::max(window.most, light);
      ++window.n;
    }
  }
  if (window.moments.n0 > 0) window.center = (1 / window.moments.n0) * window.center;
  return window;
}

double sinc(double x) {
  const double a = std::numbers::pi * x;
  return std::abs(a) < 1e-6 ? 1 : std::sin(a) / a;
}

// Harmonics beyond those that are fitted, and light that is not even, speak where a block does not
// hold whole periods. Along a border that crosses the pattern this averages out, along one that
// follows it not.
double cut_px(const Window& window, Vec2 block_px, Vec2 frequency) {
  const double lit = window.sum / (window.n * window.most);
  const double periods_x = std::max(lit * block_px.x * norm(frequency), 0.5),
               periods_y = std::max(lit * block_px.y * norm(frequency), 0.5);
  const double below = std::abs(sinc(block_px.x * frequency.x)) / (periods_y * periods_y),
               beside = std::abs(sinc(block_px.y * frequency.y)) / (periods_x * periods_x);
  return kCutError * window.unevenness() * std::hypot(below, beside);
}

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
  return true;
}

}  // namespace

std::vector<PhaseSample> grow_samples(const CellGrid& cells, Vec2 seed_px, Vec2 screen_at_seed,
                                      const ColorSeries& series, const BlockShape& shape,
                                      bool lines) {
  struct Node {
    bool done = false, accepted = false;
    PhaseSample sample;
    Mat2 jacobian;
  };
  const BlockGrid grid(cells, shape);
  const int nx = grid.nx, ny = grid.ny;
  std::vector<Node> nodes(static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny));
  const auto node_at = [&](int i, int j) -> Node& {
    return nodes[static_cast<std::size_t>(j) * static_cast<std::size_t>(nx) +
                 static_cast<std::size_t>(i)];
  };
  const auto middle = [&](int i, int j) {
    return middle_of(cells, range_of(cells, shape, i, j, 0));
  };
  using Entry = std::pair<double, std::pair<int, int>>;
  std::priority_queue<Entry> queue;

  // `predicted` and `jacobian` hold at the middle of the block.
  const auto measure = [&](int i, int j, Vec2 predicted, const Mat2& jacobian) {
    Node& node = node_at(i, j);
    node.done = true;
    const Vec2 p = middle(i, j);
    const Window window =
        window_of(cells, range_of(cells, shape, i, j, shape.reach),
                  [&](int, int, Vec2 q) { return predicted + jacobian * (q - p); });
    const Vec2 predicted_there = predicted + jacobian * (window.center - p);
    if (!make_sample(fit_shift(window.moments, series), window.center, predicted_there, lines,
                     node.sample))
      return;
    const double info = std::min(node.sample.info_u, node.sample.info_v);
    if (info < kLeastInfo) return;
    node.accepted = true;
    node.jacobian = jacobian;
    queue.push({info, {i, j}});
  };

  const double block_width = cells.size().width * shape.columns * cells.keep_every();
  const int seed_i = std::clamp(static_cast<int>(seed_px.x / block_width), 0, nx - 1);
  const int seed_j =
      std::clamp(static_cast<int>(seed_px.y / (cells.size().lines * shape.rows)), 0, ny - 1);
  const Mat2 start = carrier_matrix(cells.carriers());
  measure(seed_i, seed_j, screen_at_seed + start * (middle(seed_i, seed_j) - seed_px), start);
  std::vector<PhaseSample> samples;
  while (!queue.empty()) {
    const std::pair<int, int> place = queue.top().second;
    queue.pop();
    for (const std::pair<int, int>& step :
         {std::pair{1, 0}, std::pair{-1, 0}, std::pair{0, 1}, std::pair{0, -1}}) {
      const int ni = place.first + step.first, nj = place.second + step.second;
      if (ni < 0 || nj < 0 || ni >= nx || nj >= ny || node_at(ni, nj).done) continue;
      const Vec2 p = middle(ni, nj);
      // Prediction from a plane through the accepted neighbours, pulled towards their own slopes.
      double weight_sum = 0;
      Vec2 predicted;
      Mat2 slope{0, 0, 0, 0};
      for (int b = -2; b <= 2; ++b) {
        for (int a = -2; a <= 2; ++a) {
          const int qi = ni + a, qj = nj + b;
          if (qi < 0 || qj < 0 || qi >= nx || qj >= ny || !node_at(qi, qj).accepted) continue;
          const Node& other = node_at(qi, qj);
          const double weight = std::exp(-0.5 * (a * a + b * b));
          predicted = predicted + weight * (other.sample.s_in_screen +
                                            other.jacobian * (p - other.sample.p_in_scan));
          slope = {slope.a + weight * other.jacobian.a, slope.b + weight * other.jacobian.b,
                   slope.c + weight * other.jacobian.c, slope.d + weight * other.jacobian.d};
          weight_sum += weight;
        }
      }
      const double k = 1 / weight_sum;
      Node& fresh = node_at(ni, nj);
      const Mat2 jacobian{k * slope.a, k * slope.b, k * slope.c, k * slope.d};
      measure(ni, nj, k * predicted, jacobian);
      if (!fresh.accepted) continue;
      // Half of the surprise corrects the slope along the step (Broyden).
      const Vec2 way = fresh.sample.p_in_scan - node_at(place.first, place.second).sample.p_in_scan;
      const Vec2 surprise =
          fresh.sample.s_in_screen - (k * predicted + jacobian * (fresh.sample.p_in_scan - p));
      const double gain = 0.5 / std::max(dot(way, way), 1.0);
      fresh.jacobian.a += gain * surprise.x * way.x;
      fresh.jacobian.b += gain * surprise.x * way.y;
      fresh.jacobian.c += gain * surprise.y * way.x;
      fresh.jacobian.d += gain * surprise.y * way.y;
    }
  }
  for (const Node& node : nodes) {
    if (node.accepted) samples.push_back(node.sample);
  }
  return samples;
}

std::vector<Vec2> screen_at_cells(const CellGrid& cells, const ScreenMap& map) {
  const auto n_columns = static_cast<std::size_t>(cells.n_columns());
  std::vector<Vec2> screen(n_columns * static_cast<std::size_t>(cells.n_rows()));
  // The mean over a cell of a map that bends, by two points per axis (Gauss-Legendre).
  const double dx = map.is_affine() ? 0 : cells.size().width / std::sqrt(12.0);
  const double dy = map.is_affine() ? 0 : cells.size().lines / std::sqrt(12.0);
  parallel_for(cells.n_rows(), [&](int r) {
    for (int c = 0; c < cells.n_columns(); ++c) {
      if (!cells.kept(c)) continue;
      const Vec2 p = cells.center(c, r);
      Vec2& out = screen[static_cast<std::size_t>(r) * n_columns + static_cast<std::size_t>(c)];
      if (map.is_affine()) {
        out = map.screen_from_scan(p);
      } else {
        out = 0.25 *
              (map.screen_from_scan(p + Vec2{-dx, -dy}) + map.screen_from_scan(p + Vec2{dx, -dy}) +
               map.screen_from_scan(p + Vec2{-dx, dy}) + map.screen_from_scan(p + Vec2{dx, dy}));
      }
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
      if (!make_sample(fit_shift(window.moments, series), p, map.smooth_screen_from_scan(p), false,
                       sample))
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
      add_rephased(rows[static_cast<std::size_t>(r)], cells.cell(c, r),
                   s - carrier_phase(cells.carriers(), cells.center(c, r)), 1);
    }
  });
  Moments total;
  for (const Moments& row : rows) add_rephased(total, row, {0, 0}, 1);
  return fit_series(total, series);
}

}  // namespace reseau
