// Cubic interpolation.
#pragma once

#include <array>

namespace reseau {

// Weights of the four neighbours at t in [0, 1). slope: how far the curve follows its neighbours'
// differences; 0.5 is Catmull-Rom's (Keys 1981), less overshoots less at edges.
inline std::array<float, 4> cubic_weights(float t, float slope = 0.5F) {
  const float t2 = t * t, t3 = t2 * t;
  const float rise = 3 * t2 - 2 * t3, first = t - 2 * t2 + t3, last = t3 - t2;
  return {-slope * first, 1 - rise - slope * last, rise + slope * first, slope * last};
}

}  // namespace reseau
