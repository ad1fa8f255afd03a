#include "core/reconstruct/radial_covariance.h"

#include <cmath>
#include <numbers>

namespace reseau {

RadialCovariance::RadialCovariance(std::span<const CovarianceTerm> terms, double blur_px)
    : table_(static_cast<std::size_t>(kReachPx * kReachPx * kPerPx2) + 1, 0.0) {
  const auto add_gaussian = [this](double height, double variance_px2) {
    // exp(-x / (2 variance)) at evenly spaced x = r^2.
    const double factor = std::exp(-0.5 / (kPerPx2 * variance_px2));
    for (double& value : table_) {
      value += height;
      height *= factor;
    }
  };
  for (const CovarianceTerm& term : terms) {
    if (std::isinf(term.length_px)) {
      for (double& value : table_) value += term.variance;
      continue;
    }
    // exp(-a r) = integral over u of a / (2 sqrt(pi)) u^-3/2 exp(-a^2 / 4u) exp(-u r^2), u = 1 /
    // 2s^2; steps of sqrt(2) in s make it good to a few thousandths.
    const double a = 1 / term.length_px;
    constexpr double kLeastS = 0.1;
    const double step = 0.5 * std::numbers::ln2;
    for (double s = kLeastS; s < 8 * term.length_px; s *= std::numbers::sqrt2) {
      const double u = 1 / (2 * s * s);
      const double weight =
          a / (2 * std::sqrt(std::numbers::pi * u)) * std::exp(-a * a / (4 * u)) * 2 * step;
      const double blurred = s * s + blur_px * blur_px;
      add_gaussian(term.variance * weight * s * s / blurred, blurred);
    }
  }
}

}  // namespace reseau
