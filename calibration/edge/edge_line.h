// A nearly straight line through a picture, and distances to it. Values.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "core/geometry/vec2.h"

namespace reseau {

// Across the line: s = n . (p - middle), along it: u. The line is
//   s(u) = offset + bend (v^2 - 1/3) + twist (v^3 - 0.6 v),   v = u / half_length.
struct EdgeLine {
  Vec2 middle;
  double normal_rad = 0;  // direction of n, from +x towards +y; the signal rises along it
  double offset_px = 0;
  double bend_px = 0, twist_px = 0;
  double half_length_px = 1;

  [[nodiscard]] double at(double u) const {
    const double v = u / half_length_px;
    return offset_px + bend_px * (v * v - 1.0 / 3) + twist_px * v * (v * v - 0.6);
  }
  [[nodiscard]] double slope(double u) const {
    const double v = u / half_length_px;
    return (2 * bend_px * v + twist_px * (3 * v * v - 0.6)) / half_length_px;
  }
  [[nodiscard]] double curvature(double u) const {
    const double v = u / half_length_px;
    return (2 * bend_px + 6 * twist_px * v) / (half_length_px * half_length_px);
  }
  [[nodiscard]] bool straight() const { return bend_px == 0 && twist_px == 0; }
};

// A line with its sine and cosine at hand.
class LineFrame {
 public:
  explicit LineFrame(const EdgeLine& line)
      : line_(line), c_(std::cos(line.normal_rad)), s_(std::sin(line.normal_rad)) {}

  struct Place {
    double distance = 0;  // to the line, positive on the side of n
    double along = 0;     // u of the nearest point of the line
  };
  [[nodiscard]] Place at(double x, double y) const {
    const double dx = x - line_.middle.x, dy = y - line_.middle.y;
    const double s = c_ * dx + s_ * dy;
    double u = -s_ * dx + c_ * dy;
    if (line_.straight()) return {s - line_.offset_px, u};
    // Newton's method for the foot of the perpendicular.
    const double u0 = u;
    for (int round = 0; round < 3; ++round) {
      const double rest = s - line_.at(u), slope = line_.slope(u);
      const double curve = 1 + slope * slope - rest * line_.curvature(u);
      u += (u0 - u + rest * slope) / std::max(curve, 0.3);
    }
    const double slope = line_.slope(u);
    return {(s - line_.at(u)) * std::sqrt(1 + slope * slope), u};
  }
  // Derivatives of the distance by offset, normal_rad, bend and twist.
  [[nodiscard]] std::array<double, 4> derivatives(double u) const {
    const double v = u / line_.half_length_px;
    const double slope = line_.straight() ? 0 : line_.slope(u);
    const double shrink = slope == 0 ? 1 : 1 / std::sqrt(1 + slope * slope);
    return {-shrink, u * shrink, -(v * v - 1.0 / 3) * shrink, -v * (v * v - 0.6) * shrink};
  }
  [[nodiscard]] double cosine() const { return c_; }
  [[nodiscard]] double sine() const { return s_; }
  [[nodiscard]] const EdgeLine& line() const { return line_; }

 private:
  EdgeLine line_;
  double c_, s_;
};

}  // namespace reseau
