// How much brighter the silver is, place by place, than a picture would make it.
#pragma once

#include <cstddef>
#include <vector>

#include "core/geometry/pixel_bounds.h"
#include "core/geometry/vec2.h"
#include "core/reconstruct/silver_rows.h"

namespace reseau {

// The factor that brings the picture nearest to the silver in a window of 5 x 5 pixels, drawn to 1
// by the noise: light of all three colours alike, which is what detail mostly is. Bounded to
// 1/4 .. 4. Immutable, thread-safe.
class SilverRatio {
 public:
  static constexpr int kReach = 3;  // pixels that are needed around those that are asked for

  // `predicted`: the silver of the picture, row by row, in the rectangle. noise_sd: of a pixel over
  // the light.
  SilverRatio(const SilverRows& silver, const std::vector<float>& predicted,
              const PixelBounds& rect, double noise_sd);

  // At pixel (x, y) + part, part 0..1; at least kReach within the rectangle.
  [[nodiscard]] float at(int x, int y, float part_x, float part_y) const {
    const float* a = &values_[static_cast<std::size_t>(y - rect_.y0) * width_ +
                              static_cast<std::size_t>(x - rect_.x0)];
    if (part_x == 0 && part_y == 0) return *a;
    const float* b = a + width_;
    const float top = a[0] + part_x * (a[1] - a[0]), bottom = b[0] + part_x * (b[1] - b[0]);
    return top + part_y * (bottom - top);
  }

 private:
  PixelBounds rect_;
  std::size_t width_;
  std::vector<float> values_;
};

}  // namespace reseau
