#include "core/reconstruct/blank_blocks.h"

#include <algorithm>

namespace reseau {
namespace {
constexpr double kMostSpread = 1.2;  // of a blank block, in deviations of the noise
}  // namespace

BlankBlocks::BlankBlocks(const SilverRows& silver, const PixelBounds& area, double noise_sd)
    : area_(area) {
  if (!(noise_sd > 0 && noise_sd <= kMostNoise)) return;
  const int columns = (area.width() + kSide - 1) / kSide,
            rows = (area.height() + kSide - 1) / kSide;
  columns_ = static_cast<std::size_t>(columns);
  blocks_.resize(columns_ * static_cast<std::size_t>(rows));
  const double most_variance = kMostSpread * kMostSpread * noise_sd * noise_sd;
  for (int j = 0; j < rows; ++j) {
    const int y0 = area.y0 + j * kSide, y1 = std::min(y0 + kSide, area.y1);
    for (int i = 0; i < columns; ++i) {
      const int x0 = area.x0 + i * kSide, x1 = std::min(x0 + kSide, area.x1);
      double sum = 0, squares = 0;
      for (int y = y0; y < y1; ++y) {
        // A row of at most 32 floats sums well.
        float row_sum = 0, row_squares = 0;
        const float* from = silver.at(x0, y);
        for (int x = 0; x < x1 - x0; ++x) {
          row_sum += from[x];
          row_squares += from[x] * from[x];
        }
        sum += double{row_sum};
        squares += double{row_squares};
        // Most blocks are bright: their first row tells.
        if (sum > 2 * kMostMean * kSide * kSide) break;
      }
      const double n = static_cast<double>(x1 - x0) * (y1 - y0), mean = sum / n;
      Block& block = blocks_[static_cast<std::size_t>(j) * columns_ + static_cast<std::size_t>(i)];
      block.mean = static_cast<float>(mean);
      block.blank = mean <= kMostMean && squares / n - mean * mean <= most_variance;
      any_ = any_ || block.blank;
    }
  }
}

bool BlankBlocks::around(int x, int y, int reach) const {
  if (!any_) return false;
  const int x0 = std::max(x - reach, area_.x0), x1 = std::min(x + reach, area_.x1 - 1),
            y0 = std::max(y - reach, area_.y0), y1 = std::min(y + reach, area_.y1 - 1);
  for (int b = y0;; b = std::min(b + kSide, y1)) {
    for (int a = x0;; a = std::min(a + kSide, x1)) {
      if (!blocks_[index(a, b)].blank) return false;
      if (a >= x1) break;
    }
    if (b >= y1) break;
  }
  return true;
}

}  // namespace reseau
