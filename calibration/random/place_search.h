// Where in the whole target a picture may lie, roughly. Part of measure_random.
#pragma once

#include "calibration/random/place_fit.h"
#include "calibration/random/random_cells.h"
#include "core/geometry/vec2.h"

namespace reseau::random_target {

// Side of the square in the middle of the part that is looked at.
inline constexpr int kSearchSide_px = 32;

struct LikelyPlace {
  double likeness = -1;  // correlation
  Vec2 middle;           // of the part, in the target
  Mat2 turn;             // target from scan
};

// The whole target under a Gaussian of sigma_px, in steps of about a pixel and of two degrees.
[[nodiscard]] LikelyPlace search_target(const UsedPart& part, const RandomCells& cells,
                                        double sigma_px);

}  // namespace reseau::random_target
