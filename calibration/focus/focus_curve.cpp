#include "calibration/focus/focus_curve.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Core>
#include <Eigen/LU>

namespace reseau {
namespace {

constexpr double kLeastShare = 1.0 / 3;  // of the best modulation; beyond, ln M is no fourth power
constexpr std::size_t kLeastPoints = 3, kLeastForFourth = 6;

struct Sample {
  double x = 0, y = 0, weight = 0;  // position in units of the sweep's half width; ln M
};

struct Fit {
  Eigen::VectorXd p;  // ln peak, slope2, centre, slope4
  Eigen::MatrixXd covariance;
  double chi2 = 0;
  bool ok = false;
};

double model(const Eigen::VectorXd& p, double x) {
  const double u2 = (x - p[2]) * (x - p[2]);
  return p[0] - p[1] * u2 - (p.size() > 3 ? p[3] * u2 * u2 : 0.0);
}

// Gauss and Newton's method with halved steps.
Fit fit(const std::vector<Sample>& samples, Eigen::VectorXd p) {
  Fit out;
  const auto chi2_of = [&](const Eigen::VectorXd& at) {
    double sum = 0;
    for (const Sample& s : samples) sum += s.weight * std::pow(s.y - model(at, s.x), 2);
    return sum;
  };
  const Eigen::Index n = p.size();
  double chi2 = chi2_of(p);
  Eigen::MatrixXd normal(n, n);
  for (int round = 0; round < 60; ++round) {
    normal.setZero();
    Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
    for (const Sample& s : samples) {
      const double u = s.x - p[2];
      Eigen::VectorXd j(n);
      j[0] = 1;
      j[1] = -u * u;
      j[2] = 2 * p[1] * u;
      if (n > 3) {
        j[2] += 4 * p[3] * u * u * u;
        j[3] = -u * u * u * u;
      }
      normal += s.weight * j * j.transpose();
      right += s.weight * (s.y - model(p, s.x)) * j;
    }
    const Eigen::FullPivLU<Eigen::MatrixXd> solver(normal);
    if (!solver.isInvertible()) return out;
    const Eigen::VectorXd step = solver.solve(right);
    double share = 1, next = chi2_of(p + step);
    while (!(next <= chi2) && share > 1e-6) {
      share /= 2;
      next = chi2_of(p + share * step);
    }
    if (!(next <= chi2)) break;
    const double gain = chi2 - next;
    p += share * step;
    chi2 = next;
    if (gain <= 1e-12 * (1 + chi2) && round > 2) break;
  }
  const Eigen::FullPivLU<Eigen::MatrixXd> solver(normal);
  if (!solver.isInvertible()) return out;
  out.p = p;
  out.covariance = solver.inverse();
  out.chi2 = chi2;
  out.ok = std::isfinite(chi2) && p.allFinite();
  return out;
}

// Weighted parabola through the samples as a start; nothing when it opens upwards.
std::optional<Eigen::VectorXd> start(const std::vector<Sample>& samples) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Sample& s : samples) {
    const Eigen::Vector3d j(1, s.x, s.x * s.x);
    normal += s.weight * j * j.transpose();
    right += s.weight * s.y * j;
  }
  const Eigen::FullPivLU<Eigen::Matrix3d> solver(normal);
  if (!solver.isInvertible()) return std::nullopt;
  const Eigen::Vector3d c = solver.solve(right);
  if (!(c[2] < 0)) return std::nullopt;
  Eigen::VectorXd p(3);
  p[2] = -c[1] / (2 * c[2]);
  p[1] = -c[2];
  p[0] = c[0] + p[1] * p[2] * p[2];
  return p;
}

// Distance from the centre where ln M has fallen by `fall`.
double distance(double slope2, double slope4, double fall) {
  if (std::abs(slope4) < 1e-9 * std::abs(slope2)) return std::sqrt(fall / slope2);
  const double root = slope2 * slope2 + 4 * slope4 * fall;
  if (root < 0) return std::nan("");
  return std::sqrt((-slope2 + std::sqrt(root)) / (2 * slope4));
}

}  // namespace

double FocusFit::at(double position) const {
  const double u2 = (position - best.value) * (position - best.value);
  return peak.value * std::exp(-slope2 * u2 - slope4 * u2 * u2);
}

FocusFit fit_focus(std::span<const FocusPoint> points) {
  FocusFit out;
  double most = 0, lowest = 1e300, highest = -1e300;
  for (const FocusPoint& point : points) most = std::max(most, point.modulation);
  std::vector<const FocusPoint*> used;
  for (const FocusPoint& point : points) {
    if (!(point.modulation > kLeastShare * most) || !(point.sd > 0)) continue;
    used.push_back(&point);
    lowest = std::min(lowest, point.position);
    highest = std::max(highest, point.position);
  }
  out.n_points = static_cast<int>(used.size());
  if (used.size() < kLeastPoints || !(highest > lowest)) {
    out.why = "Best focus needs the edge at three focus settings or more.";
    return out;
  }
  const double middle = (lowest + highest) / 2, half = (highest - lowest) / 2;
  std::vector<Sample> samples;
  for (const FocusPoint* point : used) {
    const double relative = point->sd / point->modulation;
    samples.push_back({(point->position - middle) / half, std::log(point->modulation),
                       1 / (relative * relative)});
  }
  const auto begin = start(samples);
  Fit best;
  if (begin) best = fit(samples, *begin);
  if (!best.ok || !(best.p[1] > 0) || std::abs(best.p[2]) > 1) {
    out.why =
        "The modulation has no peak within the focus settings; move their middle, or spread them "
        "wider.";
    return out;
  }
  const auto n = static_cast<double>(samples.size());
  if (samples.size() >= kLeastForFourth) {
    Eigen::VectorXd with(4);
    with << best.p, 0;
    const Fit fourth = fit(samples, with);
    const double scatter = std::max(1.0, fourth.chi2 / (n - 4));
    if (fourth.ok && fourth.p[1] > 0 && std::abs(fourth.p[2]) <= 1 &&
        best.chi2 - fourth.chi2 > std::log(n) * scatter) {
      best = fourth;
    }
  }
  const double freedom = n - static_cast<double>(best.p.size());
  out.chi2_per_freedom = freedom > 0 ? best.chi2 / freedom : 0;
  best.covariance *= std::max(1.0, out.chi2_per_freedom);
  out.ok = true;
  out.best = {middle + half * best.p[2], half * std::sqrt(best.covariance(2, 2))};
  const double peak = std::exp(best.p[0]);
  out.peak = {peak, peak * std::sqrt(best.covariance(0, 0))};
  const double slope4 = best.p.size() > 3 ? best.p[3] : 0;
  out.slope2 = best.p[1] / (half * half);
  out.slope4 = slope4 / (half * half * half * half);
  const double fall = -std::log(kDepthShare);
  const double depth = distance(best.p[1], slope4, fall);
  // Not beyond the settings: there the fourth power is a guess.
  if (std::isfinite(depth) && depth <= 1 + std::abs(best.p[2])) {
    // fall = slope2 h^2 + slope4 h^4.
    const double h2 = depth * depth, slope = 2 * best.p[1] * depth + 4 * slope4 * h2 * depth;
    Eigen::VectorXd by = Eigen::VectorXd::Zero(best.p.size());
    by[1] = -h2 / slope;
    if (best.p.size() > 3) by[3] = -h2 * h2 / slope;
    out.half_depth = Measured{half * depth, half * std::sqrt(by.dot(best.covariance * by))};
  }
  return out;
}

}  // namespace reseau
