#include "core/screen/map_uncertainty.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include <Eigen/Dense>

namespace reseau {
namespace {

// Per axis: as many as the finest spline of usual film needs, and where it bends within a tile.
constexpr int kMostNodes = 24, kMostNodesOfSharpBends = 64;
constexpr double kSharpBendSpacingPx = 32;

int most_nodes(const MapErrorModel& model) {
  const bool sharp = model.spacing_px > 0 && model.spacing_px < kSharpBendSpacingPx;
  return sharp ? kMostNodesOfSharpBends : kMostNodes;
}
// Windows that lie side by side err alike, because they share the picture's edges: on simulated
// films the errors of affine maps have 1.8 times the variance that independent windows would give,
// and what splines miss twice as much again.
constexpr double kAlike = 1.8, kMissed = 2;
// What the finest splines miss, which follow nearly everything.
constexpr double kMissedBySharp = 1.3;

// Inverse of the normal matrix of a plane a x + b y + c, positions scaled.
Eigen::Matrix3d plane_covariance(const std::vector<PlacedInfo>& samples, double scale,
                                 double PlacedInfo::*info) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  for (const PlacedInfo& sample : samples) {
    const Eigen::Vector3d row(sample.p_in_scan.x / scale, sample.p_in_scan.y / scale, 1);
    normal += sample.*info * row * row.transpose();
  }
  normal += Eigen::Matrix3d::Identity() * (1e-12 * normal.trace() + 1e-300);
  return normal.inverse();
}

// Information that samples about p give to a spline of this spacing: a node's share is what lies in
// a square of one spacing, seen through a Gaussian.
double local_info(const std::vector<PlacedInfo>& samples, Vec2 p, double spacing,
                  double PlacedInfo::*info) {
  double sum = 0;
  const double reach = 2 * spacing;
  for (const PlacedInfo& sample : samples) {
    const Vec2 d = sample.p_in_scan - p;
    if (std::abs(d.x) > reach || std::abs(d.y) > reach) continue;
    sum += sample.*info * std::exp(-2 * dot(d, d) / (spacing * spacing));
  }
  return 0.637 * sum;
}

}  // namespace

MapUncertainty::MapUncertainty(const ScreenMap& map, const std::vector<PlacedInfo>& samples,
                               const MapErrorModel& claimed, int width_px, int height_px)
    : n_columns_(std::clamp(width_px / (most_nodes(claimed) > kMostNodes ? 16 : 32), 2,
                            most_nodes(claimed))),
      n_rows_(std::clamp(height_px / (most_nodes(claimed) > kMostNodes ? 16 : 32), 2,
                         most_nodes(claimed))),
      step_x_((width_px - 1) / (n_columns_ - 1.0)),
      step_y_((height_px - 1) / (n_rows_ - 1.0)),
      stage_(map.line_error()) {
  MapErrorModel model = claimed;
  model.excess_u *= kAlike;
  model.excess_v *= kAlike;
  const double scale = std::max(width_px, height_px);
  const Eigen::Matrix3d plane_u = plane_covariance(samples, scale, &PlacedInfo::info_u),
                        plane_v = plane_covariance(samples, scale, &PlacedInfo::info_v),
                        noise_u = plane_covariance(samples, scale, &PlacedInfo::noise_info_u),
                        noise_v = plane_covariance(samples, scale, &PlacedInfo::noise_info_v);
  slope_sd_ = {std::sqrt(model.excess_u * plane_u(0, 0)) / scale,
               std::sqrt(model.excess_u * plane_u(1, 1)) / scale,
               std::sqrt(model.excess_v * plane_v(0, 0)) / scale,
               std::sqrt(model.excess_v * plane_v(1, 1)) / scale};
  const double most = std::max(model.amplitude_periods * model.amplitude_periods, 1e-12);
  double bound = 0;
  for (int j = 0; j < n_rows_; ++j) {
    for (int i = 0; i < n_columns_; ++i) {
      const Vec2 p{i * step_x_, j * step_y_};
      const Eigen::Vector3d row(p.x / scale, p.y / scale, 1);
      double var_u = row.dot(plane_u * row), var_v = row.dot(plane_v * row);
      double bound_u = row.dot(noise_u * row), bound_v = row.dot(noise_v * row);
      var_u *= model.excess_u;
      var_v *= model.excess_v;
      if (model.spacing_px > 0) {
        const double info_u = local_info(samples, p, model.spacing_px, &PlacedInfo::info_u);
        const double info_v = local_info(samples, p, model.spacing_px, &PlacedInfo::info_v);
        const double missed = most_nodes(model) > kMostNodes ? kMissedBySharp : kMissed;
        var_u += 1 / (info_u / (missed * model.excess_u) + 1 / most);
        var_v += 1 / (info_v / (missed * model.excess_v) + 1 / most);
        bound_u +=
            1 / (local_info(samples, p, model.spacing_px, &PlacedInfo::noise_info_u) + 1 / most);
        bound_v +=
            1 / (local_info(samples, p, model.spacing_px, &PlacedInfo::noise_info_v) + 1 / most);
      }
      const Mat2 px = map.jacobian(p).inverse();
      covariance_.push_back({px.a * px.a * var_u + px.b * px.b * var_v,
                             px.a * px.c * var_u + px.b * px.d * var_v,
                             px.c * px.c * var_u + px.d * px.d * var_v});
      bound += (px.a * px.a + px.c * px.c) * bound_u + (px.b * px.b + px.d * px.d) * bound_v;
    }
  }
  bound_px_ = std::sqrt(bound / static_cast<double>(covariance_.size()));
}

PlaceCovariance MapUncertainty::at(Vec2 p) const {
  if (covariance_.empty()) return {};
  const double x = std::clamp(p.x / step_x_, 0.0, n_columns_ - 1.0),
               y = std::clamp(p.y / step_y_, 0.0, n_rows_ - 1.0);
  const int i = std::min(static_cast<int>(x), n_columns_ - 2),
            j = std::min(static_cast<int>(y), n_rows_ - 2);
  const double fx = x - i, fy = y - j;
  PlaceCovariance sum;
  const auto add = [&](int column, int row, double weight) {
    const PlaceCovariance& node =
        covariance_[static_cast<std::size_t>(row) * static_cast<std::size_t>(n_columns_) +
                    static_cast<std::size_t>(column)];
    sum.xx += weight * node.xx;
    sum.xy += weight * node.xy;
    sum.yy += weight * node.yy;
  };
  add(i, j, (1 - fx) * (1 - fy));
  add(i + 1, j, fx * (1 - fy));
  add(i, j + 1, (1 - fx) * fy);
  add(i + 1, j + 1, fx * fy);
  // Exactly where it was asked for: a stage is less sure of its first and last lines alone.
  const Vec2 stage = stage_.variance_at(p);
  sum.xx += stage.x;
  sum.yy += stage.y;
  return sum;
}

double MapUncertainty::rms_px() const {
  double sum = 0;
  for (const PlaceCovariance& node : covariance_) sum += node.xx + node.yy;
  if (covariance_.empty()) return 0;
  sum /= static_cast<double>(covariance_.size());
  constexpr int kSteps = 512;
  for (int k = 0; k <= kSteps; ++k) {
    const double t = static_cast<double>(k) / kSteps;
    const Vec2 stage =
        stage_.variance_at({t * step_x_ * (n_columns_ - 1), t * step_y_ * (n_rows_ - 1)});
    sum += (stage.x + stage.y) / (kSteps + 1);
  }
  return std::sqrt(sum);
}

}  // namespace reseau
