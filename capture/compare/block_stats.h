// What small squares of two pictures say about noise, shift and edges. Pure, reentrant.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace reseau::compare {

inline constexpr int kBlockPx = 16;

// Sums over one square of 16 x 16 pixels of CIELAB of both pictures.
struct Block {
  bool usable = false;  // every pixel finite in both
  std::array<double, 3> mean_a{}, mean_b{};
  // Variance about the best plane: what is left above 1/16 cycle per pixel.
  std::array<double, 3> variance_a{}, variance_b{};
  // How far A is from flat, without its noise: variance of the means of 4 x 4 pixels, L* a* b*
  // together.
  double unevenness_a = 0;
  // Structure tensor of A: products of its gradient, summed over L*, a*, b*.
  double xx = 0, xy = 0, yy = 0;
  // For the displacement: products of the mean gradient of L* with itself and with B - A.
  double gxx = 0, gxy = 0, gyy = 0, gxd = 0, gyd = 0;
};

// `lab_a` and `lab_b`: [row][pixel][3], 16 rows of `stride_px` pixels; the square begins at x_px.
[[nodiscard]] Block measure_block(std::span<const float> lab_a, std::span<const float> lab_b,
                                  std::size_t stride_px, std::size_t x_px);

struct NoiseFigures {
  int n_blocks = 0;  // flat ones, by A
  // Standard deviation in flat areas above 1/16 cycle per pixel: median over blocks, L*, a*, b*.
  std::array<double, 3> a{}, b{};
  // B over A; absent where A has none.
  std::array<std::optional<double>, 3> ratio{};
};
// The tenth of all blocks in which A is flattest, at least 4; black and blown-out ones do not
// count. No blocks: n_blocks is 0.
[[nodiscard]] NoiseFigures noise_of(std::span<const Block> blocks);

// Where things of A lie in B: b(p + shift) = a(p), from the gradients (Lucas and Kanade 1981), so
// for shifts below a pixel or the size of the finest detail; larger ones are underestimated.
struct ShiftFigures {
  bool measured = false;  // enough detail in both directions
  double x_px = 0, y_px = 0;
  double sd_x_px = 0, sd_y_px = 0;  // jackknife over the picture
};
[[nodiscard]] ShiftFigures shift_of(std::span<const Block> blocks);

// Mean of B - A over the picture, with its standard error from the scatter between blocks.
struct BiasFigures {
  int n_blocks = 0;
  std::array<double, 3> lab{}, sd{};
};
[[nodiscard]] BiasFigures bias_of(std::span<const Block> blocks);

}  // namespace reseau::compare
