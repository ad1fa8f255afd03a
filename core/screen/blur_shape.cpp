#include "core/screen/blur_shape.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace reseau {

double BlurShape::transfer(Vec2 f, double sigma_px) const {
  constexpr double kPi = std::numbers::pi;
  const double f2 = f.x * f.x * (1 + stretch) + f.y * f.y * (1 - stretch);
  if (f2 == 0) return 1;
  const double variance = sigma_px * sigma_px;
  const double gaussian = std::min(variance, in_focus_px * in_focus_px);
  double transfer = (1 - far_share) * std::exp(-2 * kPi * kPi * gaussian * f2);
  if (gaussian < variance) {
    // A disc of radius r has the variance r^2 / 4 along an axis and the transform 2 J1(x) / x,
    // x = 2 pi r f (Goodman, Introduction to Fourier Optics).
    const double x = 4 * kPi * std::sqrt((variance - gaussian) * f2);
    if (x > 1e-4) transfer *= 2 * std::cyl_bessel_j(1.0, x) / x;
  }
  return transfer;
}

}  // namespace reseau
