// Catmull-Rom interpolation.
#pragma once

#include <array>

namespace reseau {

// Weights of the four neighbours at t in [0, 1).
inline std::array<float, 4> cubic_weights(float t) {
  const float t2 = t * t, t3 = t2 * t;
  return {0.5F * (-t + 2 * t2 - t3), 0.5F * (2 - 5 * t2 + 3 * t3), 0.5F * (t + 4 * t2 - 3 * t3),
          0.5F * (t3 - t2)};
}

}  // namespace reseau
