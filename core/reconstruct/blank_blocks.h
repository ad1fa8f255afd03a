// Where the silver is so dark that nothing but noise is left of it, and all three colours are
// alike.
#pragma once

#include <cstddef>
#include <vector>

#include "core/geometry/pixel_bounds.h"
#include "core/reconstruct/silver_rows.h"

namespace reseau {

// Blocks of 32 x 32 pixels of an area. A block is blank when its mean is at most a hundredth of
// clear film and its standard deviation at most 1.2 times that of the noise: an element of another
// colour that differed from its neighbours by more than 1.5 times the noise of a pixel would show.
// Immutable, thread-safe.
class BlankBlocks {
 public:
  static constexpr int kSide = 32;
  static constexpr double kMostMean = 0.01, kMostNoise = 0.004;

  BlankBlocks() = default;  // nothing is blank
  // noise_sd: of a pixel of silver without light, at most kMostNoise; 0 = not known, nothing is
  // blank. The silver must hold the area.
  BlankBlocks(const SilverRows& silver, const PixelBounds& area, double noise_sd);

  [[nodiscard]] bool any() const { return any_; }
  // Whether everything within `reach` of (x, y) is blank.
  [[nodiscard]] bool around(int x, int y, int reach) const;
  // Of the block of (x, y), which lies in the area.
  [[nodiscard]] float mean(int x, int y) const { return blocks_[index(x, y)].mean; }
  // The first x at or after this where another block begins.
  [[nodiscard]] int block_end(int x) const {
    return area_.x0 + ((x - area_.x0) / kSide + 1) * kSide;
  }

 private:
  struct Block {
    float mean = 0;
    bool blank = false;
  };
  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>((y - area_.y0) / kSide) * columns_ +
           static_cast<std::size_t>((x - area_.x0) / kSide);
  }

  PixelBounds area_;
  std::size_t columns_ = 0;
  bool any_ = false;
  std::vector<Block> blocks_;
};

// Calls body(begin, end, skip) for the runs of a row of n pixels from column x0 on; skip:
// everything within `reach` of them is blank.
template <typename Body>
void for_runs(const BlankBlocks& blank, int x0, int y, int n, int reach, const Body& body) {
  if (!blank.any()) {
    body(0, n, false);
    return;
  }
  for (int begin = 0; begin < n;) {
    const int end = std::min(n, blank.block_end(x0 + begin) - x0);
    body(begin, end, blank.around(x0 + begin, y, reach) && blank.around(x0 + end - 1, y, reach));
    begin = end;
  }
}

}  // namespace reseau
