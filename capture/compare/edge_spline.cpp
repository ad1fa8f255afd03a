#include "capture/compare/edge_spline.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace reseau::compare {
namespace {

constexpr double kBinsPerPx = 32;
constexpr double kKnotPx = 0.25;
// Beyond this distance a profile has only its tails, which are smooth.
constexpr double kCorePx = 2.0;

struct Basis {
  int first = 0;  // coefficient of weight[0]
  std::array<double, 4> weight{}, slope{};
};

int n_coefficients(double half_width_px) {
  return static_cast<int>(std::ceil(2 * half_width_px / kKnotPx)) + 3;
}

// Cubic B-spline with knots at -W + k h; coefficient j is centred at -W + (j - 1) h.
Basis basis_at(double distance_px, double half_width_px, int n) {
  const double at = (distance_px + half_width_px) / kKnotPx;
  Basis basis;
  basis.first = std::clamp(static_cast<int>(std::floor(at)), 0, n - 4);
  const double t = at - basis.first;
  const double s = 1 - t;
  basis.weight = {s * s * s / 6, (3 * t * t * t - 6 * t * t + 4) / 6,
                  (3 * s * s * s - 6 * s * s + 4) / 6, t * t * t / 6};
  basis.slope = {-s * s / 2 / kKnotPx, (3 * t * t - 4 * t) / 2 / kKnotPx,
                 -(3 * s * s - 4 * s) / 2 / kKnotPx, t * t / 2 / kKnotPx};
  return basis;
}

struct Normal {
  Eigen::MatrixXd gram;
  Eigen::VectorXd right;
};

Normal normal_equations(const ProfileBins& samples, int n) {
  Normal normal{Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd::Zero(n)};
  for (const ProfileBins::Bin& bin : samples.bins()) {
    if (bin.n == 0) continue;
    const Basis basis = basis_at(bin.distance / bin.n, samples.half_width_px(), n);
    for (int i = 0; i < 4; ++i) {
      const double w = basis.weight[static_cast<std::size_t>(i)];
      normal.right(basis.first + i) += w * bin.value;
      for (int j = 0; j < 4; ++j) {
        normal.gram(basis.first + i, basis.first + j) +=
            bin.n * w * basis.weight[static_cast<std::size_t>(j)];
      }
    }
  }
  return normal;
}

// Squared third differences: the roughness of the line spread.
Eigen::MatrixXd penalty(double half_width_px, int n) {
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(n, n);
  constexpr std::array<double, 4> kThird{-1, 3, -3, 1};
  for (int j = 0; j + 3 < n; ++j) {
    const double x = -half_width_px + (j + 0.5) * kKnotPx;
    const double tail = 1 + x * x / (kCorePx * kCorePx);
    for (int a = 0; a < 4; ++a) {
      for (int b = 0; b < 4; ++b) {
        matrix(j + a, j + b) +=
            tail * tail * kThird[static_cast<std::size_t>(a)] * kThird[static_cast<std::size_t>(b)];
      }
    }
  }
  return matrix;
}

struct SplineFit {
  Eigen::VectorXd coefficients;
  double squares = 0;    // of the residuals
  double criterion = 0;  // generalised cross-validation
};

SplineFit fit(const ProfileBins& samples, const Normal& normal, const Eigen::MatrixXd& roughness,
              double weight, bool criterion) {
  const Eigen::LLT<Eigen::MatrixXd> llt(normal.gram + weight * roughness);
  SplineFit result;
  result.coefficients = llt.solve(normal.right);
  result.squares =
      std::max(0.0, samples.sum_of_squares() - 2 * result.coefficients.dot(normal.right) +
                        result.coefficients.dot(normal.gram * result.coefficients));
  if (criterion) {
    const double freedom = samples.count() - llt.solve(normal.gram).trace();
    result.criterion = freedom > 0 ? result.squares / (freedom * freedom) : HUGE_VAL;
  }
  return result;
}

}  // namespace

ProfileBins::ProfileBins(double half_width_px)
    : half_width_px_(half_width_px),
      bins_(static_cast<std::size_t>(std::ceil(2 * half_width_px * kBinsPerPx)) + 1) {}

void ProfileBins::add(double distance_px, double value) {
  if (!(std::abs(distance_px) <= half_width_px_)) return;
  Bin& bin = bins_[static_cast<std::size_t>((distance_px + half_width_px_) * kBinsPerPx)];
  bin.n += 1;
  bin.distance += distance_px;
  bin.value += value;
  n_ += 1;
  squares_ += value * value;
}

double ProfileBins::widest_gap_px(double range_px) const {
  double last = -range_px, widest = 0;
  for (const Bin& bin : bins_) {
    if (bin.n == 0) continue;
    const double at = bin.distance / bin.n;
    if (std::abs(at) > range_px) continue;
    widest = std::max(widest, at - last);
    last = at;
  }
  return std::max(widest, range_px - last);
}

EdgeSpline::EdgeSpline(const ProfileBins& samples, double relative_penalty)
    : half_width_px_(samples.half_width_px()) {
  const int n = n_coefficients(half_width_px_);
  const Normal normal = normal_equations(samples, n);
  const Eigen::MatrixXd roughness = penalty(half_width_px_, n);
  const double unit = samples.count() / n;
  SplineFit best;
  if (relative_penalty > 0) {
    best = fit(samples, normal, roughness, unit * relative_penalty, false);
  } else {
    for (int step = -6; step <= 6; ++step) {
      const SplineFit trial = fit(samples, normal, roughness, unit * std::pow(10.0, step), true);
      if (step == -6 || trial.criterion < best.criterion) best = trial;
    }
  }
  coefficients_.assign(best.coefficients.data(), best.coefficients.data() + n);
  residual_ = std::sqrt(best.squares / std::max(1.0, samples.count()));
}

double EdgeSpline::value(double distance_px) const {
  const Basis basis = basis_at(distance_px, half_width_px_, static_cast<int>(coefficients_.size()));
  double sum = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    sum += basis.weight[i] * coefficients_[static_cast<std::size_t>(basis.first) + i];
  }
  return sum;
}

double EdgeSpline::slope(double distance_px) const {
  const Basis basis = basis_at(distance_px, half_width_px_, static_cast<int>(coefficients_.size()));
  double sum = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    sum += basis.slope[i] * coefficients_[static_cast<std::size_t>(basis.first) + i];
  }
  return sum;
}

double EdgeSpline::mtf(double cy_per_px) const {
  // The derivative is a sum of quadratic B-splines, whose transform is sinc cubed.
  std::complex<double> sum = 0;
  for (std::size_t j = 0; j + 1 < coefficients_.size(); ++j) {
    const double phase = -2 * std::numbers::pi * cy_per_px * kKnotPx * static_cast<double>(j);
    sum += (coefficients_[j + 1] - coefficients_[j]) * std::polar(1.0, phase);
  }
  const double x = std::numbers::pi * kKnotPx * cy_per_px;
  const double sinc = x == 0 ? 1 : std::sin(x) / x;
  return std::abs(sum) * sinc * sinc * sinc / std::abs(rise());
}

double EdgeSpline::variation() const {
  double sum = 0;
  for (std::size_t j = 0; j + 1 < coefficients_.size(); ++j) {
    sum += std::abs(coefficients_[j + 1] - coefficients_[j]);
  }
  return sum;
}

}  // namespace reseau::compare
