// One blur per channel and the printed widths of a film, from the harmonics of its réseau. Include
// from .cpp files only (Eigen).
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/geometry/vec2.h"
#include "core/screen/element_model.h"
#include "core/screen/screen_pattern.h"
#include "core/screen/screen_tile.h"

namespace reseau {

// No blur beyond these is looked for [px].
inline constexpr double kLeastSigmaPx = 0.2, kMostSigmaPx = 4.0;
// What is believed of infrared beside the mean of R, G, B where nothing tells.
inline constexpr double kInfraredSofter = 1.1;

struct SharpnessFit {
  PrintedScreen printed;                // squares or discs: what fits better
  ScreenWidths widths;                  // those of `printed` where the screen has none to fit
  std::array<double, 4> sigma{}, sd{};  // R G B IR [px]
  double cost = 0;                      // chi-squared and priors
};

// Inverse variance of the weighted amplitudes of a tile: noise and detail, plus the model's own.
[[nodiscard]] double tile_weight(const ScreenTile& tile, std::size_t channel);

// n_channels: 3, or 4 with infrared. At least one tile must be used. Pure, reentrant.
[[nodiscard]] SharpnessFit fit_sharpness(const PrintedScreen& printed, const Mat2& linear,
                                         const std::vector<ScreenTile>& tiles,
                                         std::size_t n_channels);

}  // namespace reseau
