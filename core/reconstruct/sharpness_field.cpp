#include "core/reconstruct/sharpness_field.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Dense>

namespace reseau {
namespace {

constexpr int kFolds = 4;
constexpr std::size_t kFewSamples = 12;
// A higher degree must predict this much better.
constexpr double kGain = 0.97;
constexpr double kLeastVariancePx2 = 0.04;

int n_terms(int degree) { return (degree + 1) * (degree + 2) / 2; }

Vec2 unit(Vec2 p, Vec2 frame_px) {
  return {2 * p.x / std::max(frame_px.x, 1.0) - 1, 2 * p.y / std::max(frame_px.y, 1.0) - 1};
}

struct SurfaceFit {
  Eigen::VectorXd coefficients;
  Eigen::MatrixXd covariance;  // as the samples claim it
  double spread = 0;           // robust, of residuals over their claimed deviation
};

// Iterated least squares; samples of `left_out` do not count.
SurfaceFit fit_polynomial(const std::vector<BlurSample>& samples, const std::vector<int>& fold,
                          int left_out, int degree, Vec2 frame_px) {
  const int n = n_terms(degree);
  SurfaceFit fit;
  std::vector<double> trust(samples.size(), 1.0);
  std::vector<double> error(samples.size());
  std::array<double, 15> term{};
  for (int round = 0; round < 5; ++round) {
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      if (fold[i] == left_out) continue;
      const Vec2 p = unit(samples[i].at_px, frame_px);
      BlurSurface::terms(p.x, p.y, degree, term);
      const Eigen::Map<const Eigen::VectorXd> t(term.data(), n);
      const double weight = trust[i] / (samples[i].sd * samples[i].sd);
      normal += weight * t * t.transpose();
      right += weight * samples[i].variance_px2 * t;
    }
    // Enough to keep an undetermined term at zero.
    normal.diagonal().array() += 1e-6 * normal(0, 0) + 1e-30;
    const auto solver = normal.ldlt();
    fit.coefficients = solver.solve(right);
    fit.covariance = solver.solve(Eigen::MatrixXd::Identity(n, n));
    std::vector<double> sizes;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const Vec2 p = unit(samples[i].at_px, frame_px);
      BlurSurface::terms(p.x, p.y, degree, term);
      const Eigen::Map<const Eigen::VectorXd> t(term.data(), n);
      error[i] = (samples[i].variance_px2 - t.dot(fit.coefficients)) / samples[i].sd;
      if (fold[i] != left_out) sizes.push_back(std::abs(error[i]));
    }
    if (sizes.empty()) break;
    const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
    std::nth_element(sizes.begin(), middle, sizes.end());
    fit.spread = std::max(1.4826 * *middle, 1e-6);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double r = error[i] / (4.7 * fit.spread);
      trust[i] = std::abs(r) < 1 ? (1 - r * r) * (1 - r * r) : 0;
    }
  }
  return fit;
}

// Mean size of the errors in what was left out, outliers cut.
double prediction_error(const std::vector<BlurSample>& samples, const std::vector<int>& fold,
                        int degree, Vec2 frame_px, double cut) {
  double sum = 0;
  std::array<double, 15> term{};
  for (int left_out = 0; left_out < kFolds; ++left_out) {
    const SurfaceFit fit = fit_polynomial(samples, fold, left_out, degree, frame_px);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      if (fold[i] != left_out) continue;
      const Vec2 p = unit(samples[i].at_px, frame_px);
      BlurSurface::terms(p.x, p.y, degree, term);
      const Eigen::Map<const Eigen::VectorXd> t(term.data(), n_terms(degree));
      const double e = std::abs(samples[i].variance_px2 - t.dot(fit.coefficients)) / samples[i].sd;
      sum += std::min(e, cut);
    }
  }
  return sum;
}

}  // namespace

std::size_t BlurSurface::terms(double x, double y, int degree, std::array<double, 15>& out) {
  std::size_t n = 0;
  out[n++] = 1;
  for (int d = 1; d <= degree; ++d) {
    // From the terms of the degree below: times x, and the last one times y.
    const std::size_t below = n - static_cast<std::size_t>(d);
    for (int i = 0; i < d; ++i) out[n++] = x * out[below + static_cast<std::size_t>(i)];
    out[n] = y * out[below + static_cast<std::size_t>(d) - 1];
    ++n;
  }
  return n;
}

int BlurSurface::degree() const {
  int degree = 0;
  while (static_cast<std::size_t>(n_terms(degree)) < coefficients_.size()) ++degree;
  return degree;
}

double BlurSurface::sigma_px(Vec2 p) const {
  if (coefficients_.size() == 1) return std::sqrt(coefficients_[0]);
  const Vec2 q = unit(p, frame_px_);
  std::array<double, 15> term{};
  const std::size_t n =
      terms(std::clamp(q.x, -1.0, 1.0), std::clamp(q.y, -1.0, 1.0), degree(), term);
  double sum = 0;
  for (std::size_t i = 0; i < n; ++i) sum += coefficients_[i] * term[i];
  return std::clamp(std::sqrt(std::max(sum, kLeastVariancePx2)), least_, most_);
}

double BlurSurface::sd_px(Vec2 p) const {
  const std::size_t n = coefficients_.size();
  if (covariance_.size() != n * n) return 0;
  const Vec2 q = unit(p, frame_px_);
  std::array<double, 15> term{};
  terms(std::clamp(q.x, -1.0, 1.0), std::clamp(q.y, -1.0, 1.0), degree(), term);
  double variance = 0;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) variance += term[i] * term[j] * covariance_[i * n + j];
  }
  return std::sqrt(std::max(variance, 0.0)) / (2 * sigma_px(p));
}

std::array<double, 2> BlurSurface::range_px() const {
  std::array<double, 2> range{1e30, 0};
  constexpr int kSteps = 24;
  for (int j = 0; j <= kSteps; ++j) {
    for (int i = 0; i <= kSteps; ++i) {
      const double sigma = sigma_px({frame_px_.x * i / kSteps, frame_px_.y * j / kSteps});
      range = {std::min(range[0], sigma), std::max(range[1], sigma)};
    }
  }
  return range;
}

BlurSurface BlurSurface::mixed(const BlurSurface& a, double of_a, const BlurSurface& b,
                               double of_b) {
  std::vector<double> sum(std::max(a.coefficients_.size(), b.coefficients_.size()), 0.0);
  for (std::size_t i = 0; i < a.coefficients_.size(); ++i) sum[i] += of_a * a.coefficients_[i];
  for (std::size_t i = 0; i < b.coefficients_.size(); ++i) sum[i] += of_b * b.coefficients_[i];
  const auto root = [&](double x, double y) {
    return std::sqrt(std::max(of_a * x * x + of_b * y * y, kLeastVariancePx2));
  };
  return {std::move(sum), a.coefficients_.size() > 1 ? a.frame_px_ : b.frame_px_,
          root(a.least_, b.least_), root(a.most_, b.most_)};
}

BlurSurface fit_blur_surface(const std::vector<BlurSample>& samples, Vec2 frame_px, int most_degree,
                             const BlurSurface* base) {
  std::vector<BlurSample> rest = samples;
  if (base != nullptr) {
    for (BlurSample& s : rest) {
      const double sigma = base->sigma_px(s.at_px);
      s.variance_px2 -= sigma * sigma;
    }
  }
  // Folds are blocks of the frame, so that neighbours do not vouch for each other.
  std::vector<int> fold(rest.size());
  for (std::size_t i = 0; i < rest.size(); ++i) {
    const Vec2 p = unit(rest[i].at_px, frame_px);
    fold[i] = (static_cast<int>((p.x + 1) * 4) + 2 * static_cast<int>((p.y + 1) * 4)) % kFolds;
  }
  constexpr int kNone = -1;
  int best_degree = 0;
  if (rest.size() >= kFewSamples) {
    double cut = 1e30, best = 0;
    for (int degree = 0; degree <= most_degree; ++degree) {
      if (3 * static_cast<std::size_t>(n_terms(degree)) > rest.size()) break;
      if (degree == 0) cut = 4 * fit_polynomial(rest, fold, kNone, 0, frame_px).spread;
      const double error = prediction_error(rest, fold, degree, frame_px, cut);
      if (degree == 0 || error < kGain * best) {
        best = error;
        best_degree = degree;
      }
    }
  }
  const SurfaceFit fit = fit_polynomial(rest, fold, kNone, best_degree, frame_px);
  std::vector<double> coefficients(fit.coefficients.begin(), fit.coefficients.end());
  if (base != nullptr) {
    const std::vector<double>& below = base->coefficients();
    coefficients.resize(std::max(coefficients.size(), below.size()), 0.0);
    for (std::size_t i = 0; i < below.size(); ++i) coefficients[i] += below[i];
  }
  if (coefficients.size() == 1) {
    return BlurSurface(std::sqrt(std::max(coefficients[0], kLeastVariancePx2)));
  }
  // Only what the fit says at the samples is believed; beyond them it may swing.
  const BlurSurface free(coefficients, frame_px, 0.2, 10);
  double least = 1e30, most = 0;
  for (const BlurSample& s : samples) {
    const double sigma = free.sigma_px(s.at_px);
    least = std::min(least, sigma);
    most = std::max(most, sigma);
  }
  constexpr double kBeyond = 1.05;
  std::vector<double> covariance;
  // What the samples scatter by beyond their claims; a base's own uncertainty is not known.
  if (base == nullptr || base->degree() == 0) {
    const double scale = std::max(1.0, fit.spread * fit.spread);
    for (const double value : fit.covariance.reshaped()) covariance.push_back(scale * value);
  }
  return {std::move(coefficients), std::move(covariance), frame_px, least / kBeyond,
          most * kBeyond};
}

}  // namespace reseau
