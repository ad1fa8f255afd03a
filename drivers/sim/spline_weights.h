#pragma once

#include <array>

namespace reseau::sim {

// The uniform cubic B-spline: weights of the four knots about a place that lies the fraction f of
// the way from the second to the third.
inline std::array<double, 4> spline_weights(double f) {
  const double g = 1 - f;
  return {g * g * g / 6, (3 * f * f * f - 6 * f * f + 4) / 6, (3 * g * g * g - 6 * g * g + 4) / 6,
          f * f * f / 6};
}

}  // namespace reseau::sim
