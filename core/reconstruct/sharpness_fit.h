// One blur per channel and the printed widths of a film, from the harmonics of its réseau. Include
// from .cpp files only (Eigen).
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <limits>
#include <vector>

#include "core/geometry/vec2.h"
#include "core/reconstruct/blur_table.h"
#include "core/screen/blur_shape.h"
#include "core/screen/screen_pattern.h"
#include "core/screen/screen_tile.h"

namespace reseau {

// What is believed of infrared beside the mean of R, G, B where nothing tells.
inline constexpr double kInfraredSofter = 1.1;

// What is believed of the blurs before the picture is seen [px]: R G B IR.
struct SharpnessPrior {
  std::array<double, 4> sigma_px{0.7, 0.7, 0.7, 0.7}, sd_px{0.5, 0.5, 0.5, 0.5};
  // Infrared by itself; otherwise it is believed to be a little softer than the others.
  bool infrared = false;
};

struct SharpnessFit {
  PrintedScreen printed;                // squares or discs: what fits better
  ScreenWidths widths;                  // those of `printed` where the screen has none to fit
  BlurShape shape;                      // its stretch fitted
  double stretch_sd = 0;                // 0 where it was not fitted
  std::array<double, 4> sigma{}, sd{};  // R G B IR [px]
  double cost = 0;                      // chi-squared and priors
};

// Inverse variance of the weighted amplitudes of a tile: noise and detail, plus the model's own.
[[nodiscard]] double tile_weight(const ScreenTile& tile, std::size_t channel);

// Of a tile's blur, over that of its channel; asked by index of the tile and channel.
using RelativeBlur = std::function<double(std::size_t tile, std::size_t channel)>;

struct SharpnessTask {
  PrintedScreen printed;
  Mat2 linear;  // screen from scan [periods/px]
  SharpnessPrior prior;
  BlurShape shape;             // where the fit of its stretch begins
  RelativeBlur relative_blur;  // empty: the same everywhere
  std::size_t n_channels = 3;  // 3, or 4 with infrared
};

// At least one tile must be used. Pure, reentrant.
[[nodiscard]] SharpnessFit fit_sharpness(const SharpnessTask& task,
                                         const std::vector<ScreenTile>& tiles);

}  // namespace reseau
