#include "core/reconstruct/silver_ratio.h"

#include <algorithm>
#include <array>

namespace reseau {
namespace {

// A picture varies by so much within a period: less of the ratio than noise makes is not believed.
constexpr double kVariation = 0.15;
constexpr float kMostFactor = 4;
// Below this light nothing is multiplied.
constexpr float kDark = 0.002F;
constexpr int kWindow = 2;
constexpr std::array<float, 5> kWeights{1.0F / 16, 4.0F / 16, 6.0F / 16, 4.0F / 16, 1.0F / 16};
// Sum of the squares of the window's weights.
constexpr double kNoiseLeft = (70.0 / 256) * (70.0 / 256);

}  // namespace

SilverRatio::SilverRatio(const SilverRows& silver, const std::vector<float>& predicted,
                         const PixelBounds& rect, double noise_sd)
    : rect_(rect),
      width_(static_cast<std::size_t>(rect.width())),
      values_(width_ * static_cast<std::size_t>(rect.height()), 1.0F) {
  const auto pull =
      static_cast<float>(noise_sd * noise_sd * kNoiseLeft / (kVariation * kVariation));
  const std::size_t n = width_;
  // Along y, then along x.
  std::vector<float> above(2 * n);
  for (int y = rect.y0 + kWindow; y < rect.y1 - kWindow; ++y) {
    std::fill(above.begin(), above.end(), 0.0F);
    int row = y - kWindow;
    for (const float weight : kWeights) {
      const float* s = silver.at(rect.x0, row);
      const float* p = &predicted[static_cast<std::size_t>(row - rect.y0) * n];
      ++row;
      for (std::size_t x = 0; x < n; ++x) {
        above[x] += weight * s[x] * p[x];
        above[n + x] += weight * p[x] * p[x];
      }
    }
    float* to = &values_[static_cast<std::size_t>(y - rect.y0) * n];
    for (std::size_t x = kWindow; x + kWindow < n; ++x) {
      float both = 0, square = 0;
      for (std::size_t k = 0; k < kWeights.size(); ++k) {
        both += kWeights[k] * above[x + k - kWindow];
        square += kWeights[k] * above[n + x + k - kWindow];
      }
      const float prior = pull * square + kDark * kDark;
      to[x] = std::clamp((both + prior) / (square + prior), 1 / kMostFactor, kMostFactor);
    }
  }
}

}  // namespace reseau
