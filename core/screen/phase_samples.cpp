#include "core/screen/phase_samples.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <queue>
#include <utility>

#include <Eigen/Dense>

#include "core/base/parallel.h"
#include "core/screen/element_model.h"

namespace reseau {
namespace {

// Surer than this, or a sample is not used at all [1/periods^2]: one sigma of 0.12 periods.
constexpr double kLeastInfo = 1 / (0.12 * 0.12);
// A step of more than this from the prediction may be a neighbouring period.
constexpr double kLargestStep = 0.25;

Vec2 carrier_phase(const Carriers& f, Vec2 p) { return {dot(f.u, p), dot(f.v, p)}; }

Mat2 carrier_matrix(const Carriers& f) { return {f.u.x, f.u.y, f.v.x, f.v.y}; }

// Where the brightness of a window has its centre, against where the window has it. Blur moves the
// pattern up the slope of the brightness s by blur^2 grad(ln s); the mean of grad(ln s) over a
// Gaussian window with the weight s^2 is half the offset of the centre of s^2 over the window's
// own variance, whatever the picture looks like inside.
struct Slope {
  Vec2 bright, all;
  double sum_bright = 0, sum_all = 0;
  void add(Vec2 offset, double weight, double light) {
    bright = bright + (weight * light) * offset;
    all = all + weight * offset;
    sum_bright += weight * light;
    sum_all += weight;
  }
  [[nodiscard]] Vec2 log_gradient(double sigma_px) const {
    if (!(sum_bright > 0)) return {};
    return (0.5 / (sigma_px * sigma_px)) * ((1 / sum_bright) * bright - (1 / sum_all) * all);
  }
};

// Sums the cells about (column, row) as seen by `screen_at`, a prediction of screen coordinates.
template <typename Predict>
Moments window_at(const CellGrid& cells, double column, double row, double sigma,
                  const Predict& predict, Slope* slope = nullptr) {
  Moments window;
  const int reach = static_cast<int>(std::ceil(2.5 * sigma));
  const int c0 = std::max(0, static_cast<int>(std::floor(column)) - reach);
  const int c1 = std::min(cells.n_columns() - 1, static_cast<int>(std::ceil(column)) + reach);
  const int r0 = std::max(0, static_cast<int>(std::floor(row)) - reach);
  const int r1 = std::min(cells.n_rows() - 1, static_cast<int>(std::ceil(row)) + reach);
  for (int r = r0; r <= r1; ++r) {
    for (int c = c0; c <= c1; ++c) {
      const double distance = (c - column) * (c - column) + (r - row) * (r - row);
      const double weight = std::exp(-0.5 * distance / (sigma * sigma));
      if (slope != nullptr) {
        slope->add({kCellPx * (c - column), kCellPx * (r - row)}, weight, cells.light(c, r));
      }
      if (!(cells.light(c, r) > 0)) continue;
      const Vec2 p = cells.center(c, r);
      add_rephased(window, cells.cell(c, r), predict(p) - carrier_phase(cells.carriers(), p),
                   weight);
    }
  }
  return window;
}

bool make_sample(const Shift& shift, Vec2 p, Vec2 predicted, PhaseSample& sample) {
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
  return true;
}

}  // namespace

std::vector<PhaseSample> grow_samples(const CellGrid& cells, Vec2 seed_px, Vec2 screen_at_seed,
                                      const ColorSeries& series, const WindowShape& shape) {
  struct Node {
    bool done = false, accepted = false;
    PhaseSample sample;
    Mat2 jacobian;
  };
  const int stride = shape.stride_cells;
  const int nx = (cells.n_columns() + stride - 1) / stride;
  const int ny = (cells.n_rows() + stride - 1) / stride;
  std::vector<Node> nodes(static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny));
  const auto node_at = [&](int i, int j) -> Node& {
    return nodes[static_cast<std::size_t>(j) * static_cast<std::size_t>(nx) +
                 static_cast<std::size_t>(i)];
  };
  const auto cell_of = [&](int i, int n) { return std::min(i * stride + stride / 2, n - 1); };
  using Entry = std::pair<double, std::pair<int, int>>;
  std::priority_queue<Entry> queue;

  const auto measure = [&](int i, int j, Vec2 predicted, const Mat2& jacobian) {
    Node& node = node_at(i, j);
    node.done = true;
    const int column = cell_of(i, cells.n_columns()), row = cell_of(j, cells.n_rows());
    const Vec2 p = cells.center(column, row);
    const Moments window = window_at(cells, column, row, shape.sigma_cells,
                                     [&](Vec2 q) { return predicted + jacobian * (q - p); });
    if (!make_sample(fit_shift(window, series), p, predicted, node.sample)) return;
    const double info = std::min(node.sample.info_u, node.sample.info_v);
    if (info < kLeastInfo) return;
    node.accepted = true;
    node.jacobian = jacobian;
    queue.push({info, {i, j}});
  };

  const int seed_i = std::clamp(static_cast<int>(seed_px.x / (kCellPx * stride)), 0, nx - 1);
  const int seed_j = std::clamp(static_cast<int>(seed_px.y / (kCellPx * stride)), 0, ny - 1);
  const Mat2 start = carrier_matrix(cells.carriers());
  const Vec2 seed_center =
      cells.center(cell_of(seed_i, cells.n_columns()), cell_of(seed_j, cells.n_rows()));
  measure(seed_i, seed_j, screen_at_seed + start * (seed_center - seed_px), start);
  std::vector<PhaseSample> samples;
  while (!queue.empty()) {
    const auto [i, j] = queue.top().second;
    queue.pop();
    for (const auto& [di, dj] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
      const int ni = i + di, nj = j + dj;
      if (ni < 0 || nj < 0 || ni >= nx || nj >= ny || node_at(ni, nj).done) continue;
      const Vec2 p = cells.center(cell_of(ni, cells.n_columns()), cell_of(nj, cells.n_rows()));
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
      const Vec2 step = p - node_at(i, j).sample.p_in_scan;
      const Vec2 surprise = fresh.sample.s_in_screen - k * predicted;
      const double gain = 0.5 / dot(step, step);
      fresh.jacobian.a += gain * surprise.x * step.x;
      fresh.jacobian.b += gain * surprise.x * step.y;
      fresh.jacobian.c += gain * surprise.y * step.x;
      fresh.jacobian.d += gain * surprise.y * step.y;
    }
  }
  for (const Node& node : nodes) {
    if (node.accepted) samples.push_back(node.sample);
  }
  return samples;
}

std::vector<PhaseSample> measure_samples(const CellGrid& cells, const ScreenMap& map,
                                         const ColorSeries& series, const WindowShape& shape,
                                         double blur_px2) {
  const int stride = shape.stride_cells;
  const int nx = (cells.n_columns() + stride - 1) / stride;
  const int ny = (cells.n_rows() + stride - 1) / stride;
  // Where the map puts the centre of each cell, once for all windows that share it.
  std::vector<Vec2> screen(static_cast<std::size_t>(cells.n_columns()) *
                           static_cast<std::size_t>(cells.n_rows()));
  parallel_for(cells.n_rows(), [&](int r) {
    for (int c = 0; c < cells.n_columns(); ++c) {
      screen[static_cast<std::size_t>(r) * static_cast<std::size_t>(cells.n_columns()) +
             static_cast<std::size_t>(c)] = map.screen_from_scan(cells.center(c, r));
    }
  });
  const auto screen_at = [&](Vec2 q) {
    const auto c = static_cast<std::size_t>(std::lround((q.x + 0.5) / kCellPx - 0.5));
    const auto r = static_cast<std::size_t>(std::lround((q.y + 0.5) / kCellPx - 0.5));
    return screen[r * static_cast<std::size_t>(cells.n_columns()) + c];
  };
  std::vector<std::vector<PhaseSample>> rows(static_cast<std::size_t>(ny));
  parallel_for(ny, [&](int j) {
    for (int i = 0; i < nx; ++i) {
      const int column = std::min(i * stride + stride / 2, cells.n_columns() - 1);
      const int row = std::min(j * stride + stride / 2, cells.n_rows() - 1);
      Slope slope;
      const Moments window = window_at(cells, column, row, shape.sigma_cells, screen_at, &slope);
      const Vec2 p = cells.center(column, row);
      PhaseSample sample;
      if (!make_sample(fit_shift(window, series), p, screen_at(p), sample)) continue;
      const Vec2 drift = blur_px2 * slope.log_gradient(shape.sigma_cells * kCellPx);
      sample.s_in_screen = sample.s_in_screen - map.jacobian(p) * drift;
      if (std::max(sample.info_u, sample.info_v) < kLeastInfo) continue;
      rows[static_cast<std::size_t>(j)].push_back(sample);
    }
  });
  std::vector<PhaseSample> samples;
  for (const auto& row : rows) samples.insert(samples.end(), row.begin(), row.end());
  return samples;
}

double pattern_blur_px2(const ColorSeries& series, const ScreenMap& map) {
  // As many amplitudes as the series has; the rest of the model's are not measured here.
  constexpr int kKnown = 1 + kSeries;
  const ElementModel model(map.linear(), {});
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

bool pooled_series(const CellGrid& cells, const ScreenMap& map, ColorSeries& series) {
  std::vector<Moments> rows(static_cast<std::size_t>(cells.n_rows()));
  parallel_for(cells.n_rows(), [&](int r) {
    for (int c = 0; c < cells.n_columns(); ++c) {
      if (!(cells.light(c, r) > 0)) continue;
      const Vec2 p = cells.center(c, r);
      add_rephased(rows[static_cast<std::size_t>(r)], cells.cell(c, r),
                   map.screen_from_scan(p) - carrier_phase(cells.carriers(), p), 1);
    }
  });
  Moments total;
  for (const Moments& row : rows) add_rephased(total, row, {0, 0}, 1);
  return fit_series(total, series);
}

}  // namespace reseau
