#include "core/screen/map_fit.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "core/base/parallel.h"
#include "core/screen/spline_surface.h"

namespace reseau {
namespace {

constexpr int kRobustRounds = 3;
constexpr double kCauchy = 3.0;  // residuals beyond this many sigmas fade

struct Affine {
  Mat2 linear;
  Vec2 offset;
  [[nodiscard]] Vec2 operator()(Vec2 p) const { return linear * p + offset; }
};

struct Weighted {
  std::vector<double> u, v;
};

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Weighted least squares of one coordinate on (x, y, 1), positions scaled for conditioning.
Eigen::Vector3d fit_plane(const std::vector<PhaseSample>& samples,
                          const std::vector<double>& weights, double scale, bool along_u) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Eigen::Vector3d row(samples[i].p_in_scan.x / scale, samples[i].p_in_scan.y / scale, 1);
    const double value = along_u ? samples[i].s_in_screen.x : samples[i].s_in_screen.y;
    normal += weights[i] * row * row.transpose();
    right += weights[i] * value * row;
  }
  normal += Eigen::Matrix3d::Identity() * (1e-12 * normal.trace());
  Eigen::Vector3d plane = normal.ldlt().solve(right);
  plane(0) /= scale;
  plane(1) /= scale;
  return plane;
}

Affine fit_affine(const std::vector<PhaseSample>& samples, const Weighted& weights, double scale) {
  const Eigen::Vector3d u = fit_plane(samples, weights.u, scale, true);
  const Eigen::Vector3d v = fit_plane(samples, weights.v, scale, false);
  return {{u(0), u(1), v(0), v(1)}, {u(2), v(2)}};
}

// Multiplies the information of each sample by a Cauchy weight of its residual.
Weighted robust_weights(const std::vector<PhaseSample>& samples,
                        const std::vector<Vec2>& residuals) {
  Weighted weights;
  for (const bool along_u : {true, false}) {
    std::vector<double> normalised;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double info = along_u ? samples[i].info_u : samples[i].info_v;
      const double r = along_u ? residuals[i].x : residuals[i].y;
      if (info > 0) normalised.push_back(std::abs(r) * std::sqrt(info));
    }
    const double sigma = std::max(1.4826 * median(normalised), 1e-12);
    auto& out = along_u ? weights.u : weights.v;
    out.resize(samples.size());
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double info = along_u ? samples[i].info_u : samples[i].info_v;
      const double r = (along_u ? residuals[i].x : residuals[i].y) * std::sqrt(std::max(info, 0.0));
      const double k = r / (kCauchy * sigma);
      // One sample in full light must not outweigh hundreds: cap what the model error allows.
      constexpr double kMostInfo = 1 / (0.002 * 0.002);
      out[i] = info > 0 ? std::min(info, kMostInfo) / (1 + k * k) : 0.0;
    }
  }
  return weights;
}

double rms_px(const std::vector<PhaseSample>& samples, const Affine& affine,
              const Weighted& weights) {
  const Mat2 inverse = affine.linear.inverse();
  double sum = 0, total = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Vec2 px = inverse * (samples[i].s_in_screen - affine(samples[i].p_in_scan));
    const double weight = std::min(weights.u[i], weights.v[i]);
    sum += weight * dot(px, px);
    total += weight;
  }
  return total > 0 ? std::sqrt(sum / total) : 0;
}

// Variance of weighed residuals over what the weights claim; `n_parameters` were fitted to them.
double excess_of(const std::vector<double>& weights, const std::vector<Vec2>& residuals,
                 bool along_u, double n_parameters) {
  double sum = 0, n = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (!(weights[i] > 0)) continue;
    const double r = along_u ? residuals[i].x : residuals[i].y;
    sum += weights[i] * r * r;
    n += 1;
  }
  return std::max(sum / std::max(n - n_parameters, 0.25 * n + 1), 0.05);
}

// What one coordinate of the samples leaves after the affine map.
ScatteredValues leftovers(const std::vector<PhaseSample>& samples, const Affine& affine,
                          const std::vector<double>& weights, bool along_u) {
  ScatteredValues values;
  values.weights = weights;
  for (const PhaseSample& sample : samples) {
    const Vec2 d = sample.s_in_screen - affine(sample.p_in_scan);
    values.positions.push_back(sample.p_in_scan);
    values.values.push_back(along_u ? d.x : d.y);
  }
  return values;
}

}  // namespace

MapFit fit_map(const std::vector<PhaseSample>& samples, int width_px, int height_px,
               double finest_px, double flat_px, const LevelPlan& plan) {
  MapFit fit;
  if (samples.size() < 6) return fit;
  const double scale = std::max(width_px, height_px);
  std::vector<Vec2> residuals(samples.size());
  Weighted weights = robust_weights(samples, residuals);
  Affine affine;
  // First without any trust in the tails: film that bends leaves large residuals of an affine map,
  // and they are not outliers.
  affine = fit_affine(samples, weights, scale);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    residuals[i] = samples[i].s_in_screen - affine(samples[i].p_in_scan);
  }

  SurfaceLevels levels = surface_levels(width_px, height_px, finest_px);
  SplineSurface surface_u, surface_v;
  for (int round = 0; round < kRobustRounds; ++round) {
    ScatteredValues u = leftovers(samples, affine, weights.u, true);
    ScatteredValues v = leftovers(samples, affine, weights.v, false);
    const int n_started = plan.start != nullptr ? 1 : 0;
    if (round < n_started) {
      levels = *plan.start;
    } else if (round < n_started + plan.n_choices) {
      levels = surface_levels(width_px, height_px, finest_px);
      if (rms_px(samples, affine, weights) > flat_px) {
        choose_levels({&u, &v}, width_px, height_px, levels);
      }
    }
    if (levels.flat()) {
      affine = fit_affine(samples, weights, scale);
      for (std::size_t i = 0; i < samples.size(); ++i) {
        residuals[i] = samples[i].s_in_screen - affine(samples[i].p_in_scan);
      }
    } else {
      parallel_for(2, [&](int direction) {
        if (direction == 0) surface_u = fit_surface(u, width_px, height_px, levels);
        if (direction == 1) surface_v = fit_surface(v, width_px, height_px, levels);
      });
      for (std::size_t i = 0; i < samples.size(); ++i) {
        residuals[i] = {u.values[i] - surface_u.at(samples[i].p_in_scan),
                        v.values[i] - surface_v.at(samples[i].p_in_scan)};
      }
    }
    weights = robust_weights(samples, residuals);
  }

  if (levels.flat()) {
    fit.map = ScreenMap(affine.linear, affine.offset);
  } else {
    std::vector<Vec2> coefficients(surface_u.coefficients.size());
    for (std::size_t i = 0; i < coefficients.size(); ++i) {
      coefficients[i] = {surface_u.coefficients[i], surface_v.coefficients[i]};
    }
    fit.map = ScreenMap(affine.linear, affine.offset, surface_u.spacing_px, surface_u.n_columns,
                        surface_u.n_rows, std::move(coefficients));
  }
  double sum = 0, sum_weights = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double ratio =
        samples[i].info_u > 0 ? weights.u[i] / std::min(samples[i].info_u, 1 / (0.002 * 0.002)) : 1;
    if (ratio < 0.3) {
      ++fit.n_outliers;
      continue;
    }
    ++fit.n_used;
    const Mat2 inverse = fit.map.jacobian(samples[i].p_in_scan).inverse();
    const Vec2 px = inverse * residuals[i];
    const double weight = std::min(samples[i].info_u, samples[i].info_v);
    sum += weight * dot(px, px);
    sum_weights += weight;
  }
  fit.residual_px = sum_weights > 0 ? std::sqrt(sum / sum_weights) : 0;
  fit.levels = levels;
  MapErrorModel& errors = fit.error_model;
  double n_parameters = 3;
  if (!levels.flat()) {
    for (std::size_t i = 0; i < levels.spacing_px.size(); ++i) {
      if (levels.stiffness[i] >= 0) errors.spacing_px = levels.spacing_px[i];
    }
    n_parameters +=
        static_cast<double>(width_px) * height_px / (errors.spacing_px * errors.spacing_px);
    double square = 0;
    for (const PhaseSample& sample : samples) {
      const Vec2 d = fit.map.displacement(sample.p_in_scan);
      square += dot(d, d);
    }
    errors.amplitude_periods = std::sqrt(square / static_cast<double>(samples.size()));
  }
  errors.excess_u = excess_of(weights.u, residuals, true, n_parameters);
  errors.excess_v = excess_of(weights.v, residuals, false, n_parameters);
  for (std::size_t i = 0; i < samples.size(); ++i)
    fit.placed.push_back({samples[i].p_in_scan, weights.u[i], weights.v[i], samples[i].noise_info_u,
                          samples[i].noise_info_v});
  fit.usable = affine.linear.determinant() != 0 && std::isfinite(fit.residual_px);
  return fit;
}

}  // namespace reseau
