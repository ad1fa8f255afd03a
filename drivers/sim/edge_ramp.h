#pragma once

#include <algorithm>
#include <cmath>

namespace reseau::sim {

// Mean of a half plane over a square cell. With the cell projected on the gradient of a coordinate
// s, the mean is a ramp: the convolution of two boxes as wide as the two projected sides.
class EdgeRamp {
 public:
  EdgeRamp() = default;
  // s_x, s_y: change of s over one cell along x and y.
  EdgeRamp(double s_x, double s_y) {
    const double wide = std::max(std::abs(s_x), std::abs(s_y));
    // A box narrower than this is a step for float arithmetic.
    const double narrow = std::max(std::min(std::abs(s_x), std::abs(s_y)), 0.002 * wide);
    outer_ = static_cast<float>((wide + narrow) / 2);
    inner_ = static_cast<float>((wide - narrow) / 2);
    gain_ = static_cast<float>(1 / (2 * wide * narrow));
  }
  // The same over a cell whose weight falls evenly from its middle to those of its neighbours (a
  // tent), for edges near the directions of its sides: a triangle across the edge.
  static EdgeRamp tent(double s_x, double s_y) {
    const double length = std::hypot(s_x, s_y);
    return {length, length, length};
  }
  // Mean of (s > 0) over a cell with s = d at its centre.
  [[nodiscard]] float operator()(float d) const {
    // Clamping by absolute values: compilers turn it into vector code, comparisons not.
    d = 0.5F * (std::abs(d + outer_) - std::abs(d - outer_));
    return gain_ * (square(d + outer_) - square(d + inner_) - square(d - inner_));
  }
  // How fast that mean changes with d.
  [[nodiscard]] float slope(float d) const {
    d = 0.5F * (std::abs(d + outer_) - std::abs(d - outer_));
    return gain_ * (twice(d + outer_) - twice(d + inner_) - twice(d - inner_));
  }
  // Distance from the edge beyond which the mean is 0 or 1.
  [[nodiscard]] float reach() const { return outer_; }

 private:
  // Two boxes that are given, convolved.
  EdgeRamp(double wide, double narrow, double /*both*/)
      : outer_(static_cast<float>((wide + narrow) / 2)),
        inner_(static_cast<float>((wide - narrow) / 2)),
        gain_(static_cast<float>(1 / (2 * wide * narrow))) {}
  // Of the positive part.
  static float square(float t) { return 0.5F * t * (t + std::abs(t)); }
  static float twice(float t) { return t + std::abs(t); }
  float outer_ = 0.5F, inner_ = 0.4F, gain_ = 1.0F;
};

}  // namespace reseau::sim
