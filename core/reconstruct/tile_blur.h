// Blur tile by tile, and what the tiles together say of its shape and of how it changes over the
// frame. Include from .cpp files only (Eigen).
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/geometry/vec2.h"
#include "core/reconstruct/blur_table.h"
#include "core/reconstruct/sharpness_field.h"
#include "core/screen/screen_tile.h"

namespace reseau {

struct MeasuredTiles {
  std::vector<ScreenTile> tiles;
  std::vector<Vec2> middles;  // [px]
};

// R G B IR; channels beyond n_channels are left as they were.
struct BlurField {
  std::array<BlurSurface, 4> surface;
  // What the tiles of R, G and B leave unexplained at their own best blurs, each at most a little.
  double misfit = 0;
};

// A blur that changes over the frame is followed tile by tile. Infrared, which shows the réseau
// only where the picture is coloured, takes its shape from R, G, B where it must. about_px: of the
// whole frame.
[[nodiscard]] BlurField fit_blur_field(const MeasuredTiles& measured, const BlurTable& table,
                                       const std::array<double, 4>& about_px,
                                       std::size_t n_channels, Vec2 frame_px);

}  // namespace reseau
