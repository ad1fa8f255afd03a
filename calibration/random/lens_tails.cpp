#include "calibration/random/lens_tails.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>

#include "calibration/edge/optics.h"

namespace reseau::random_target {
namespace {

constexpr std::array<int, 4> kFitted{kDiffraction, kSigma2, kAperture2, kAspect2};
using Vector4 = Eigen::Matrix<double, 4, 1>;
using Matrix4 = Eigen::Matrix<double, 4, 4>;

struct LensFit {
  EdgeOptics optics;
  double chi2 = 0;
  Matrix4 curvature;
};

// Of the light beyond a square of this half side, per px of 1 / cut-off.
double outside_per_px(double half_px) {
  constexpr double kPi = std::numbers::pi;
  return 4 * std::numbers::sqrt2 / (kPi * kPi * kPi * half_px);
}

// What is left over: all light's model less the part inside, and how it changes.
double misfit(const AxisTransfer& t, const EdgeOptics& optics, double per_px,
              const Eigen::LDLT<Eigen::MatrixXd>& weight, Vector4* right, Matrix4* curvature) {
  const Eigen::Index n = t.value.size();
  Eigen::VectorXd rest(n);
  Eigen::MatrixXd slope(n, 4);
  for (Eigen::Index i = 0; i < n; ++i) {
    std::array<double, 1 + kFitted.size()> model{};
    const NormalCosines normal{t.along_x[i], 1 - t.along_x[i]};
    transfer(optics, normal, t.f_cy_per_px[i], kFitted, model);
    const double inside = 1 - per_px * optics.diffraction_px;
    rest[i] = t.value[i] - model[0] / inside;
    for (Eigen::Index k = 0; k < 4; ++k) {
      slope(i, k) = model[static_cast<std::size_t>(k) + 1] / inside;
    }
    slope(i, 0) += model[0] * per_px / (inside * inside);
  }
  const Eigen::VectorXd weighted = weight.solve(rest);
  if (right != nullptr) {
    *right = slope.transpose() * weighted;
    *curvature = slope.transpose() * weight.solve(slope);
  }
  return rest.dot(weighted);
}

LensFit lens_from(const AxisTransfer& t, double per_px, double aperture_px,
                  const Eigen::LDLT<Eigen::MatrixXd>& weight) {
  LensFit out;
  out.optics.diffraction_px = 0.7;
  out.optics.aperture2_px2 = aperture_px * aperture_px;
  double damping = 1e-3;
  Vector4 right;
  out.chi2 = misfit(t, out.optics, per_px, weight, &right, &out.curvature);
  for (int round = 0; round < 60 && damping < 1e8; ++round) {
    Matrix4 damped = out.curvature;
    damped.diagonal() *= 1 + damping;
    const Vector4 step = damped.ldlt().solve(right);
    EdgeOptics next = out.optics;
    for (std::size_t k = 0; k < kFitted.size(); ++k) {
      parameter(next, kFitted[k]) += step[static_cast<Eigen::Index>(k)];
    }
    const bool sane = step.allFinite() && std::abs(next.diffraction_px) < 5 &&
                      std::abs(next.sigma2_px2) < 16 && std::abs(next.aperture2_px2) < 64 &&
                      next.aspect2 > 0.02 && next.aspect2 < 50;
    const double chi2 = sane ? misfit(t, next, per_px, weight, nullptr, nullptr) : 0;
    if (!sane || !(chi2 < out.chi2)) {
      damping *= 10;
      continue;
    }
    const bool done = out.chi2 - chi2 < 1e-6 * out.chi2;
    out.optics = next;
    damping = std::max(1e-9, damping / 10);
    out.chi2 = misfit(t, out.optics, per_px, weight, &right, &out.curvature);
    if (done) break;
  }
  return out;
}

}  // namespace

LensTails fit_tails(const AxisTransfer& transfer, double half_px) {
  const double per_px = outside_per_px(half_px);
  // The law of the tails and the shape of the lens are this good.
  constexpr double kModel = 1e-3;
  Eigen::MatrixXd covariance = transfer.covariance;
  covariance.diagonal().array() += kModel * kModel;
  const Eigen::LDLT<Eigen::MatrixXd> weight(covariance);
  LensFit best = lens_from(transfer, per_px, 1, weight);
  LensFit other = lens_from(transfer, per_px, 2, weight);
  if (other.chi2 < best.chi2) best = other;
  LensTails out;
  const double freedom = static_cast<double>(transfer.value.size()) - 4;
  const Matrix4 inverse = best.curvature.ldlt().solve(Matrix4::Identity());
  out.diffraction_px = std::max(0.0, best.optics.diffraction_px);
  out.diffraction_sd = std::sqrt(std::max(0.0, inverse(0, 0)) * std::max(1.0, best.chi2 / freedom));
  out.outside = per_px * out.diffraction_px;
  out.outside_sd = per_px * out.diffraction_sd;
  out.ok = std::isfinite(out.diffraction_sd) && out.outside < 0.5;
  return out;
}

}  // namespace reseau::random_target
