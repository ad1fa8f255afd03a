// The silver of a scan, deconvolved place by place.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/geometry/vec2.h"
#include "core/reconstruct/blur_levels.h"
#include "core/reconstruct/sharpness_field.h"

namespace reseau {

// Pixels of silver, [row][pixel], the first of them at (x0, y0) of the scan.
struct SilverPlane {
  float* values = nullptr;
  std::ptrdiff_t stride = 0;
  int x0 = 0, y0 = 0, width = 0, height = 0;
};

// Dust and pinholes, small places far darker or brighter than all that lies whole periods away,
// take no part: what lies whole periods away stands in for them while the rest is sharpened, so
// that nothing rings about them, and they themselves stay as they are. Borrows its arguments.
// Immutable, thread-safe.
class SilverSharpener {
 public:
  // Levels that were made with a deconvolution.
  SilverSharpener(const BlurLevels& levels, const BlurSurface& blur,
                  const std::array<Vec2, 2>& period_px);

  // What changes a pixel lies at most so far from it.
  [[nodiscard]] int reach_px() const { return reach_px_; }
  // In place; right but for a border of reach_px().
  void sharpen(const SilverPlane& plane) const;

 private:
  [[nodiscard]] std::vector<unsigned char> spots(const SilverPlane& plane) const;
  // Weighs the pixels about each by the kernel of its place.
  void convolve(const SilverPlane& plane, const std::vector<float>& in,
                std::vector<float>& out) const;

  const BlurLevels& levels_;
  const BlurSurface& blur_;
  std::array<std::array<int, 2>, 4> ways_{};  // [px], whole periods to four sides
  int kernel_radius_ = 0, grow_ = 0, reach_px_ = 0, iterations_ = 0;
};

}  // namespace reseau
