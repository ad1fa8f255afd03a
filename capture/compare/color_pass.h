// One pass over two pictures by bands: colour difference of every pixel and sums of small squares.
#pragma once

#include <functional>
#include <span>
#include <stop_token>
#include <vector>

#include "capture/compare/block_stats.h"
#include "capture/compare/compare.h"

namespace reseau::compare {

// One side: which part of the picture, and how its XYZ become CIELAB.
struct Side {
  Picture* picture = nullptr;
  Rect area;                     // inside the picture
  Matrix3 lab_xyz = kIdentity3;  // on its XYZ: fit and adaptation
  Xyz white{};                   // of CIELAB
  bool clamp = false;
};

struct ColorPass {
  bool stopped = false;
  std::vector<float> delta_e;  // [row][pixel] of the area; NaN where one of the two is not finite
  long long n_not_finite = 0;
  bool same_samples = true;
  double max_abs = 0;
  int blocks_across = 0, blocks_down = 0;
  std::vector<Block> blocks;  // row by row
};
// The areas have the same size. On all cores; the result does not depend on their number.
[[nodiscard]] ColorPass run_color_pass(const Side& a, const Side& b, const std::stop_token& stop);

// Mean XYZ (after `lab_xyz`) of both over the pixels that are finite in both, and the sums of a
// least-squares gain.
struct FitSums {
  Xyz mean_a{}, mean_b{};
  double ab = 0, bb = 0;  // of Y
  long long n = 0;
};
[[nodiscard]] FitSums run_fit_pass(const Side& a, const Side& b, const std::stop_token& stop);

// XYZ of part of a picture, [row][pixel][3].
[[nodiscard]] std::vector<float> read_xyz(Picture& picture, const Rect& area);

// Mean, median, 95th percentile (nearest rank) and maximum of what is left of `values` without its
// largest `worst_fraction`. Reorders; NaN must not be among them.
[[nodiscard]] DifferenceFigures figures_of(std::span<float> values, double worst_fraction);

[[nodiscard]] ErrorRaster raster_of(std::span<const float> delta_e, int width_px, int height_px,
                                    int longest_side);

}  // namespace reseau::compare
