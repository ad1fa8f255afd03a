// The uniform cubic B-spline, as maps and surfaces use it.
#pragma once

#include <algorithm>
#include <array>

namespace reseau {

// The four weights and their derivatives at t in [0, 1).
struct SplineWeights {
  std::array<double, 4> value;
  std::array<double, 4> slope;
};

inline SplineWeights spline_weights(double t) {
  const double s = 1 - t;
  return {{s * s * s / 6, (3 * t * t * t - 6 * t * t + 4) / 6,
           (-3 * t * t * t + 3 * t * t + 3 * t + 1) / 6, t * t * t / 6},
          {-s * s / 2, (3 * t * t - 4 * t) / 2, (-3 * t * t + 2 * t + 1) / 2, t * t / 2}};
}

// Interval of the knots that holds a position; coefficient i sits at (i - 1) * spacing. Outside the
// knots the nearest interval is used at its border: constant there, never extrapolated.
struct SplineInterval {
  int index;
  double t;
  bool inside;
};

inline SplineInterval locate_interval(double position, double spacing, int n_coefficients) {
  const double cell = position / spacing;
  const double last = n_coefficients - 3;
  const double clamped = std::clamp(cell, 0.0, last);
  const int index = std::min(static_cast<int>(clamped), n_coefficients - 4);
  return {index, clamped - index, cell >= 0 && cell <= last};
}

}  // namespace reseau
