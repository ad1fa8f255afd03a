// Weights of the pixels around an element, or around a pixel, for every way the two can lie to each
// other: computed once per picture (and per step of sharpness), looked up for every element.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "core/geometry/vec2.h"
#include "core/reconstruct/blurred_cell.h"
#include "core/reconstruct/local_estimator.h"
#include "core/screen/screen_pattern.h"

namespace reseau {

// A kind of element: one of each per period.
struct ElementSite {
  int color = 0;
  Vec2 middle;  // [periods]
};

// The intensity of an element from the 13 x 13 pixels about the pixel nearest to its middle.
// Immutable, thread-safe.
class ElementKernels {
 public:
  static constexpr int kRadius = 6, kSide = 2 * kRadius + 1, kRow = 16;

  ElementKernels(const BlurredCell& cell, const EstimatorSettings& settings,
                 const std::vector<ElementSite>& sites);

  // fx, fy: the element's middle less that pixel, -0.5..0.5. kSide rows of kRow weights, the last
  // three of a row zero.
  [[nodiscard]] const float* of(std::size_t site, float fx, float fy) const {
    const auto index = [](float f) {
      return static_cast<std::size_t>(
          std::clamp(static_cast<int>((f + 0.5F) * kPhases), 0, kPhases - 1));
    };
    return &table_[((site * kPhases + index(fy)) * kPhases + index(fx)) * kSide * kRow];
  }
  // Largest root of the sum of squared weights: what noise of a pixel becomes in an element.
  [[nodiscard]] double noise_gain() const { return noise_gain_; }

 private:
  // The pattern is even about the middle of an element: an error of half a step, 0.06 px, changes
  // the result by its square only.
  static constexpr int kPhases = 8;
  std::vector<float> table_;
  double noise_gain_ = 0;
};

// What the pixels about a pixel add to its three colours. Applied to what a smooth picture does not
// explain, so that a small error of the phase is an error of detail alone. Immutable, thread-safe.
class DetailKernels {
 public:
  static constexpr int kRadius = 7, kSide = 2 * kRadius + 1, kRow = 16;

  // `offset_px`: where the picture's pixel lies from the silver's.
  DetailKernels(const BlurredCell& cell, const EstimatorSettings& settings, Vec2 offset_px);

  // For a pixel at (u, v): kSide rows of three colours of kRow weights, the last of a row zero.
  [[nodiscard]] const float* of(float u, float v) const {
    const auto index = [](float s) {
      return static_cast<std::size_t>(
          std::min(static_cast<int>((s - std::floor(s)) * kPhases), kPhases - 1));
    };
    return &table_[(index(v) * kPhases + index(u)) * kSide * 3 * kRow];
  }

 private:
  static constexpr int kPhases = 16;
  std::vector<float> table_;
};

}  // namespace reseau
