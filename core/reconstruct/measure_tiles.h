// The harmonics of the réseau at up to some 200 places of the frame. Include from .cpp files only
// (Eigen).
#pragma once

#include <stop_token>

#include "core/line/line_source.h"
#include "core/reconstruct/reconstruct.h"
#include "core/reconstruct/tile_blur.h"

namespace reseau {

// Tiles of 64 px or six periods, at most 14 x 14, none overlapping. Throws what the source throws.
[[nodiscard]] MeasuredTiles measure_tiles(const LineSource& source,
                                          const Registration& registration, const ToneCurves& tone,
                                          const std::stop_token& stop);

}  // namespace reseau
