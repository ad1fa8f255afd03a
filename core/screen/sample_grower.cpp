#include "core/screen/sample_grower.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/Dense>

#include "core/screen/phase_window.h"

namespace reseau {
namespace {

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

// What is expected of a film that bends from one small block to the next, one sigma: how far
// neighbours' slopes are wrong, and the curvature, both as relative changes of the frequency.
constexpr double kSlopeSd = 0.05, kCurveSdPerPx = 0.02;
constexpr double kSampleSdPeriods = 0.02;

}  // namespace

SampleGrower::SampleGrower(const CellGrid& cells, const ColorSeries& series,
                           const BlockShape& shape)
    : cells_(cells),
      series_(series),
      shape_(shape),
      // Small blocks that see beyond their borders are for film that bends from one to the next.
      bends_(shape.reach > 0),
      nx_(BlockGrid(cells, shape).nx),
      ny_(BlockGrid(cells, shape).ny),
      nodes_(static_cast<std::size_t>(nx_) * static_cast<std::size_t>(ny_)) {}

Vec2 SampleGrower::middle(int i, int j) const {
  return middle_of(cells_, range_of(cells_, shape_, i, j, 0));
}

void SampleGrower::measure(int i, int j, const Prediction& there) {
  Node& node = node_at(i, j);
  node.done = true;
  const Vec2 p = middle(i, j);
  const Window window =
      window_of(cells_, range_of(cells_, shape_, i, j, shape_.reach),
                [&](int, int, Vec2 q) { return there.screen + there.jacobian * (q - p); });
  const Vec2 predicted = there.screen + there.jacobian * (window.center - p);
  const Shift shift = fit_shift(window.moments, series_);
  if (!(std::max(std::abs(shift.delta.x), std::abs(shift.delta.y)) < most_step_)) return;
  if (!make_sample(shift, window.center, predicted, cells_.carriers().lines, node.sample)) return;
  const double info = std::min(node.sample.info_u, node.sample.info_v);
  if (info < kLeastInfo) return;
  node.accepted = true;
  node.jacobian = there.jacobian;
  queue_.push({info, {i, j}});
}

void SampleGrower::start(const LatticeSeed& seed) {
  const double width = cells_.size().width * shape_.columns * cells_.keep_every();
  const int i = std::clamp(static_cast<int>(seed.center_px.x / width), 0, nx_ - 1);
  const int j = std::clamp(static_cast<int>(seed.center_px.y / (cells_.size().lines * shape_.rows)),
                           0, ny_ - 1);
  const Mat2 slopes = seed.at_center.matrix();
  measure(i, j, {seed.screen_at_center + slopes * (middle(i, j) - seed.center_px), slopes});
}

// Value and slopes at p of a paraboloid through the neighbours, their own slopes known roughly.
// weights: of each neighbour, by its distance.
SampleGrower::Prediction SampleGrower::bent(const Neighbours& neighbours, Vec2 p,
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

// From a plane through the accepted neighbours, pulled towards their own slopes.
SampleGrower::Prediction SampleGrower::predict(int i, int j) {
  const int reach = bends_ ? 3 : 2;
  const Vec2 p = middle(i, j);
  double weight_sum = 0;
  Vec2 screen;
  Mat2 slope{0, 0, 0, 0};
  Neighbours neighbours;
  for (int b = -reach; b <= reach; ++b) {
    for (int a = -reach; a <= reach; ++a) {
      const int qi = i + a, qj = j + b;
      if (qi < 0 || qj < 0 || qi >= nx_ || qj >= ny_ || !node_at(qi, qj).accepted) continue;
      const Node& other = node_at(qi, qj);
      const double weight = std::exp(-0.5 * (a * a + b * b));
      neighbours.emplace_back(&other, std::sqrt(weight));
      screen = screen +
               weight * (other.sample.s_in_screen + other.jacobian * (p - other.sample.p_in_scan));
      slope = {slope.a + weight * other.jacobian.a, slope.b + weight * other.jacobian.b,
               slope.c + weight * other.jacobian.c, slope.d + weight * other.jacobian.d};
      weight_sum += weight;
    }
  }
  const double k = 1 / weight_sum;
  const Prediction flat{k * screen, {k * slope.a, k * slope.b, k * slope.c, k * slope.d}};
  return bends_ ? bent(neighbours, p, flat) : flat;
}

void SampleGrower::step_to(int i, int j, const Node& from) {
  const Prediction there = predict(i, j);
  measure(i, j, there);
  Node& fresh = node_at(i, j);
  if (!fresh.accepted || bends_) return;
  // Half of the surprise corrects the slope along the step (Broyden).
  const Vec2 way = fresh.sample.p_in_scan - from.sample.p_in_scan;
  const Vec2 surprise = fresh.sample.s_in_screen -
                        (there.screen + there.jacobian * (fresh.sample.p_in_scan - middle(i, j)));
  const double gain = 0.5 / std::max(dot(way, way), 1.0);
  fresh.jacobian.a += gain * surprise.x * way.x;
  fresh.jacobian.b += gain * surprise.x * way.y;
  fresh.jacobian.c += gain * surprise.y * way.x;
  fresh.jacobian.d += gain * surprise.y * way.y;
}

void SampleGrower::grow(int end_block_row) {
  const int before = end_row_;
  end_row_ = std::clamp(end_block_row, end_row_, ny_);
  // What waited at the end of the lines goes on from there.
  for (int i = 0; before > 0 && before < end_row_ && i < nx_; ++i) wake(i, before - 1);
  spread();
}

void SampleGrower::measure_all(const ScreenMap& map, double most_step) {
  most_step_ = most_step;
  for (int j = 0; j < ny_; ++j) {
    for (int i = 0; i < nx_; ++i) {
      const Vec2 p = middle(i, j);
      measure(i, j, {map.screen_from_scan(p), map.jacobian(p)});
    }
  }
  queue_ = {};
}

std::vector<bool> SampleGrower::accepted() const {
  std::vector<bool> accepted(nodes_.size());
  for (std::size_t n = 0; n < nodes_.size(); ++n) accepted[n] = nodes_[n].accepted;
  return accepted;
}

void SampleGrower::wake(int i, int j) {
  const Node& node = node_at(i, j);
  if (node.accepted) queue_.push({std::min(node.sample.info_u, node.sample.info_v), {i, j}});
}

void SampleGrower::spread() {
  while (!queue_.empty()) {
    const auto [column, row] = queue_.top().second;
    queue_.pop();
    for (const auto& [di, dj] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
      const int i = column + di, j = row + dj;
      if (i < 0 || j < 0 || i >= nx_ || j >= end_row_ || node_at(i, j).done) continue;
      step_to(i, j, node_at(column, row));
    }
  }
}

std::vector<PhaseSample> SampleGrower::samples() const {
  std::vector<PhaseSample> samples;
  for (const Node& node : nodes_) {
    if (node.accepted) samples.push_back(node.sample);
  }
  return samples;
}

}  // namespace reseau
