#include <algorithm>
#include <cmath>
#include <queue>
#include <utility>
#include <vector>

#include <Eigen/Dense>

#include "core/screen/phase_samples.h"
#include "core/screen/phase_window.h"

namespace reseau {
namespace {

Mat2 carrier_matrix(const Carriers& f) { return {f.u.x, f.u.y, f.v.x, f.v.y}; }

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

struct Node {
  bool done = false, accepted = false;
  PhaseSample sample;
  Mat2 jacobian;
};

// What is expected of a film that bends from one small block to the next, one sigma: how far
// neighbours' slopes are wrong, and the curvature, both as relative changes of the frequency.
constexpr double kSlopeSd = 0.05, kCurveSdPerPx = 0.02;
constexpr double kSampleSdPeriods = 0.02;

struct Prediction {
  Vec2 screen;
  Mat2 jacobian;
};

// Value and slopes at p of a paraboloid through the neighbours, their own slopes known roughly.
// weights: of each neighbour, by its distance.
Prediction bent_prediction(const std::vector<std::pair<const Node*, double>>& neighbours, Vec2 p,
                           const Prediction& flat) {
  using Row = Eigen::Matrix<double, 1, 6>;
  constexpr double kUnitPx = 8;
  Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 2> right = Eigen::Matrix<double, 6, 2>::Zero();
  for (const auto& [node, weight] : neighbours) {
    const Vec2 d = (1 / kUnitPx) * (node->sample.p_in_scan - p);
    Row row;
    row << 1, d.x, d.y, d.x * d.x, d.x * d.y, d.y * d.y;
    // Of the flat prediction's slopes only a correction is sought.
    const Vec2 rest = node->sample.s_in_screen - flat.screen - kUnitPx * (flat.jacobian * d);
    const double w = weight / (kSampleSdPeriods * kSampleSdPeriods);
    normal += w * row.transpose() * row;
    right.col(0) += w * rest.x * row.transpose();
    right.col(1) += w * rest.y * row.transpose();
  }
  const double frequency = std::sqrt(std::abs(flat.jacobian.determinant()));
  const double slope_sd = kSlopeSd * frequency * kUnitPx,
               curve_sd = kCurveSdPerPx * frequency * kUnitPx * kUnitPx;
  for (int i = 0; i < 6; ++i) {
    const double sd = i == 0 ? 1 : i < 3 ? slope_sd : curve_sd;
    normal(i, i) += 1 / (sd * sd);
  }
  const Eigen::Matrix<double, 6, 2> fit = normal.ldlt().solve(right);
  Prediction bent = flat;
  bent.screen = bent.screen + Vec2{fit(0, 0), fit(0, 1)};
  bent.jacobian.a += fit(1, 0) / kUnitPx;
  bent.jacobian.b += fit(2, 0) / kUnitPx;
  bent.jacobian.c += fit(1, 1) / kUnitPx;
  bent.jacobian.d += fit(2, 1) / kUnitPx;
  return bent;
}

}  // namespace

std::vector<PhaseSample> grow_samples(const CellGrid& cells, const LatticeSeed& seed,
                                      const ColorSeries& series, const BlockShape& shape,
                                      bool lines) {
  const BlockGrid grid(cells, shape);
  // Small blocks that see beyond their borders are for film that bends from one to the next.
  const bool bends = shape.reach > 0;
  const int reach = bends ? 3 : 2;
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
  const int seed_i = std::clamp(static_cast<int>(seed.center_px.x / block_width), 0, nx - 1);
  const int seed_j =
      std::clamp(static_cast<int>(seed.center_px.y / (cells.size().lines * shape.rows)), 0, ny - 1);
  const Mat2 start = carrier_matrix(seed.at_center);
  measure(seed_i, seed_j, seed.screen_at_center + start * (middle(seed_i, seed_j) - seed.center_px),
          start);
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
      std::vector<std::pair<const Node*, double>> neighbours;
      for (int b = -reach; b <= reach; ++b) {
        for (int a = -reach; a <= reach; ++a) {
          const int qi = ni + a, qj = nj + b;
          if (qi < 0 || qj < 0 || qi >= nx || qj >= ny || !node_at(qi, qj).accepted) continue;
          const Node& other = node_at(qi, qj);
          const double weight = std::exp(-0.5 * (a * a + b * b));
          neighbours.emplace_back(&other, std::sqrt(weight));
          predicted = predicted + weight * (other.sample.s_in_screen +
                                            other.jacobian * (p - other.sample.p_in_scan));
          slope = {slope.a + weight * other.jacobian.a, slope.b + weight * other.jacobian.b,
                   slope.c + weight * other.jacobian.c, slope.d + weight * other.jacobian.d};
          weight_sum += weight;
        }
      }
      const double k = 1 / weight_sum;
      Prediction there{k * predicted, {k * slope.a, k * slope.b, k * slope.c, k * slope.d}};
      if (bends) there = bent_prediction(neighbours, p, there);
      Node& fresh = node_at(ni, nj);
      measure(ni, nj, there.screen, there.jacobian);
      if (!fresh.accepted || bends) continue;
      // Half of the surprise corrects the slope along the step (Broyden).
      const Vec2 way = fresh.sample.p_in_scan - node_at(place.first, place.second).sample.p_in_scan;
      const Vec2 surprise =
          fresh.sample.s_in_screen - (there.screen + there.jacobian * (fresh.sample.p_in_scan - p));
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

}  // namespace reseau
