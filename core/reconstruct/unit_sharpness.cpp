#include "core/reconstruct/unit_sharpness.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace reseau {

std::optional<UnitBlur> unit_blur(std::span<const TransferPoint> curve, const Mat2& linear) {
  constexpr double kPi = std::numbers::pi, kLeastTransfer = 0.03, kLeastSd = 0.002;
  const double u = std::hypot(linear.a, linear.b), v = std::hypot(linear.c, linear.d);
  const double low = 0.9 * std::min(u, v), high = 2 * std::max(u, v);
  // A straight line through log M against f^2.
  double n = 0, x = 0, y = 0, xx = 0, xy = 0, reached = 0;
  int points = 0;
  for (const TransferPoint& p : curve) {
    if (p.f_cy_per_px < low || p.f_cy_per_px > high || !(p.value > kLeastTransfer)) continue;
    const double sd = std::max(p.sd, kLeastSd) / p.value;
    const double weight = 1 / (sd * sd), f2 = p.f_cy_per_px * p.f_cy_per_px;
    const double log_m = std::log(p.value);
    n += weight;
    x += weight * f2;
    y += weight * log_m;
    xx += weight * f2 * f2;
    xy += weight * f2 * log_m;
    reached = p.f_cy_per_px;
    ++points;
  }
  const double spread = n * xx - x * x;
  if (points < 4 || !(reached > 1.4 * low) || !(spread > 0)) return std::nullopt;
  const double slope = (n * xy - x * y) / spread, at_zero = (y - slope * x) / n;
  constexpr double kPerVariance = 2 * kPi * kPi;
  if (!(slope < 0) || !std::isfinite(at_zero)) return std::nullopt;
  UnitBlur blur;
  blur.sigma_px = std::sqrt(-slope / kPerVariance);
  // Points of one curve err together: no more is believed than of a single one.
  blur.sd_px = std::sqrt(points * n / spread) / kPerVariance / (2 * blur.sigma_px);
  blur.far_share = std::clamp(1 - std::exp(at_zero), -0.1, 0.5);
  return blur;
}

std::optional<BlurSurface> unit_surface(const UnitBlur& blur, const UnitField& field,
                                        Vec2 frame_px) {
  constexpr double kAlike = 0.02;
  if (!(std::abs(frame_px.x - field.frame_px[0]) <= kAlike * frame_px.x) ||
      !(std::abs(frame_px.y - field.frame_px[1]) <= kAlike * frame_px.y) ||
      field.coefficients.empty()) {
    return std::nullopt;
  }
  std::vector<double> variance = field.coefficients;
  // The mean over the frame of x^2 and of y^2 is a third.
  const double squares = variance.size() == 6 ? (variance[3] + variance[5]) / 3 : 0;
  variance[0] = blur.sigma_px * blur.sigma_px - squares;
  const BlurSurface free(variance, frame_px, 0, 1e3);
  const std::array<double, 2> range = free.range_px();
  return BlurSurface(std::move(variance), field.covariance, frame_px, range[0], range[1]);
}

}  // namespace reseau
