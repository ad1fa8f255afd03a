#include "core/screen/line_error.h"

#include <cstddef>

#include "core/screen/cubic_spline.h"

namespace reseau {

Vec2 LineError::at_position(double position_px) const {
  const SplineInterval at =
      locate_interval(position_px, spacing_px, static_cast<int>(coefficients.size()));
  const SplineWeights w = spline_weights(at.t);
  Vec2 sum;
  for (std::size_t i = 0; i < 4; ++i) {
    sum = sum + w.value[i] * coefficients[static_cast<std::size_t>(at.index) + i];
  }
  return sum;
}

Vec2 LineError::variance_at(Vec2 p) const {
  if (none() || variance_px2.size() != coefficients.size()) return {};
  const SplineInterval at =
      locate_interval(position(p), spacing_px, static_cast<int>(coefficients.size()));
  const SplineWeights w = spline_weights(at.t);
  Vec2 sum;
  for (std::size_t i = 0; i < 4; ++i) {
    sum = sum + w.value[i] * variance_px2[static_cast<std::size_t>(at.index) + i];
  }
  return sum;
}

Vec2 LineError::slope_at(Vec2 p) const {
  if (none()) return {};
  const SplineInterval at =
      locate_interval(position(p), spacing_px, static_cast<int>(coefficients.size()));
  if (!at.inside) return {};
  const SplineWeights w = spline_weights(at.t);
  Vec2 sum;
  for (std::size_t i = 0; i < 4; ++i) {
    sum = sum + (w.slope[i] / spacing_px) * coefficients[static_cast<std::size_t>(at.index) + i];
  }
  return sum;
}

}  // namespace reseau
