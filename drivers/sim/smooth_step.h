#pragma once

namespace reseau::sim {

// 0 below -1/2, 1 above 1/2, a cubic between.
[[nodiscard]] inline float smooth_step(float t) {
  t += 0.5F;
  t = t > 0.0F ? t : 0.0F;
  t = t < 1.0F ? t : 1.0F;
  return t * t * (3.0F - 2.0F * t);
}

}  // namespace reseau::sim
