// The unit cell of the réseau as the scanner sees it: the three masks, blurred.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "core/geometry/vec2.h"
#include "core/reconstruct/deconvolution.h"
#include "core/screen/blur_shape.h"
#include "core/screen/screen_pattern.h"

namespace reseau {

// Share of each element in the light of a pixel whose centre lies at (u, v). The three sum to 1.
// Immutable, thread-safe.
class BlurredCell {
 public:
  // sigma_px: blur, pixel aperture included, of that shape; screen_from_scan: the linear part
  // of the map [periods/px].
  // sharpened: how the pixels were deconvolved since; null where they were not.
  BlurredCell(const ScreenPattern& pattern, const Mat2& screen_from_scan, double sigma_px,
              const BlurShape& shape = {}, const SharpeningKernel* sharpened = nullptr);

  // Bilinear in a table of 128 x 128.
  [[nodiscard]] std::array<float, 3> shares(float u, float v) const {
    const float x = (u - std::floor(u)) * kSize, y = (v - std::floor(v)) * kSize;
    const auto ix = static_cast<std::size_t>(x), iy = static_cast<std::size_t>(y);
    const float fx = x - static_cast<float>(ix), fy = y - static_cast<float>(iy);
    const float* a = &table_[(iy * kRow + ix) * kStride];
    const float* b = a + kRow * kStride;
    std::array<float, kStride> m;
    for (std::size_t k = 0; k < kStride; ++k) {
      const float top = a[k] + fx * (a[k + kStride] - a[k]);
      const float bottom = b[k] + fx * (b[k + kStride] - b[k]);
      m[k] = top + fy * (bottom - top);
    }
    return {m[0], m[1], m[2]};
  }

  // What one collected element of colour k (row) holds of each colour (column) on average when
  // pixels are weighed by the square of their share: the saturation loss.
  [[nodiscard]] const std::array<std::array<double, 3>, 3>& mean_crosstalk() const {
    return crosstalk_;
  }

 private:
  // Two extra rows and columns repeat the first; a fourth, unused colour makes vectors of four.
  static constexpr std::size_t kSize = 128, kRow = kSize + 2, kStride = 4;
  std::vector<float> table_;  // [v][u][colour]
  std::array<std::array<double, 3>, 3> crosstalk_{};
};

}  // namespace reseau
