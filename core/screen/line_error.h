// Where the stage really stood when it should have been at a line: an error along the motion (and a
// little across) that all pixels of a line share.
#pragma once

#include <vector>

#include "core/geometry/vec2.h"

namespace reseau {

// Cubic B-spline along one axis of the scan: coefficient i sits at (i - 1) * spacing_px, values are
// displacements of the film under the line [px]: the pixel p of the scan saw what an ideal scanner
// sees at p + at(p). Immutable value.
struct LineError {
  enum class Axis { kNone, kLines, kColumns };  // the coordinate it depends on: none, y, x
  Axis axis = Axis::kNone;
  double spacing_px = 0;
  std::vector<Vec2> coefficients;
  std::vector<Vec2> variance_px2;  // of each coefficient, or empty

  [[nodiscard]] bool none() const { return axis == Axis::kNone; }
  [[nodiscard]] double position(Vec2 p) const { return axis == Axis::kColumns ? p.x : p.y; }
  [[nodiscard]] Vec2 at(Vec2 p) const { return none() ? Vec2{} : at_position(position(p)); }
  [[nodiscard]] Vec2 at_position(double position_px) const;
  // How uncertain the error is there, along x and along y [px^2]; zero when nobody said.
  [[nodiscard]] Vec2 variance_at(Vec2 p_in_scan) const;
  // Derivative along the axis [px/px].
  [[nodiscard]] Vec2 slope_at(Vec2 p) const;
};

}  // namespace reseau
