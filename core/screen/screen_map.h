// Registration: where on the réseau each scan pixel lies.
#pragma once

#include <vector>

#include "core/geometry/vec2.h"
#include "core/screen/line_error.h"

namespace reseau {

// screen_from_scan: an affine map plus a smooth displacement on a grid of cubic B-spline
// coefficients, seen by a stage whose lines may err: s = smooth(p + line_error(p)). Screen
// coordinates (u, v) are in periods; for Dufaycolor u runs along the red lines and v across them,
// (0, 0) is the centre of a green element, (0.5, 0) of a blue one, red lines lie at v = 0.5.
// Immutable value; copies are cheap enough to hand out; thread-safe to read.
class ScreenMap {
 public:
  ScreenMap() = default;
  // Affine only: s = linear * p + offset.
  ScreenMap(Mat2 linear, Vec2 offset);
  // With displacement: coefficient (i, j) of the cubic B-spline sits at scan position
  // ((i - 1) * spacing_px, (j - 1) * spacing_px); values are displacements in periods.
  ScreenMap(Mat2 linear, Vec2 offset, double spacing_px, int n_columns, int n_rows,
            std::vector<Vec2> coefficients);

  // The same film under a stage with this error, which replaces the one so far.
  [[nodiscard]] ScreenMap with_line_error(LineError line) const;

  [[nodiscard]] Vec2 screen_from_scan(Vec2 p_in_scan) const;
  // Derivative of the above at p: rows u and v, columns x and y [periods/px].
  [[nodiscard]] Mat2 jacobian(Vec2 p_in_scan) const;
  // Inverse by Newton's method; `guess` in scan pixels. Returns the best point reached.
  [[nodiscard]] Vec2 scan_from_screen(Vec2 s_in_screen, Vec2 guess_in_scan) const;

  [[nodiscard]] const Mat2& linear() const { return linear_; }
  [[nodiscard]] Vec2 offset() const { return offset_; }
  // The same with all screen coordinates raised by so much.
  [[nodiscard]] ScreenMap shifted(Vec2 by) const;
  // The film alone, as an ideal scanner sees it.
  [[nodiscard]] ScreenMap without_line_error() const { return with_line_error({}); }
  // The same at one point, without a copy.
  [[nodiscard]] Vec2 smooth_screen_from_scan(Vec2 p_ideal) const;
  [[nodiscard]] const LineError& line_error() const { return line_; }
  [[nodiscard]] bool is_affine() const { return coefficients_.empty() && line_.none(); }
  // What the smooth displacement and the line error add to the affine map there [periods].
  [[nodiscard]] Vec2 displacement(Vec2 p_in_scan) const {
    return screen_from_scan(p_in_scan) - (linear_ * p_in_scan + offset_);
  }

 private:
  // Of the smooth part alone, where an ideal scanner sees the point.
  [[nodiscard]] Mat2 smooth_jacobian(Vec2 p) const;

  Mat2 linear_;
  Vec2 offset_;
  double spacing_px_ = 0;
  int n_columns_ = 0, n_rows_ = 0;
  std::vector<Vec2> coefficients_;
  LineError line_;
};

}  // namespace reseau
