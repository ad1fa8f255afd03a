// Screens of lines alone (Joly, Warner-Powrie): where the lines of three colours lie, which is
// which and in which direction they follow one another, from the first two harmonics along one
// direction.
#pragma once

#include <vector>

#include "core/geometry/vec2.h"
#include "core/screen/lattice_hypothesis.h"
#include "core/screen/linear_rows.h"
#include "core/screen/window_fit.h"

namespace reseau {

// The carriers of lines alone with this frequency across them: v points from red over green to
// blue, u runs along the lines and is as long.
[[nodiscard]] Carriers carriers_of_lines(Vec2 frequency);

// Like judge_lattice. `tile_frequencies`: across the lines, near each tile, of either sign.
[[nodiscard]] LatticeHypothesis judge_lines(const LinearRows& rows,
                                            const std::vector<TileCorner>& tiles,
                                            const std::vector<Vec2>& tile_frequencies,
                                            int tile_size, bool infrared);

// Turns a series to where its two harmonics agree on the origin. Returns the variance of the blur
// that their ratio tells [px^2].
[[nodiscard]] double settle_lines(ColorSeries& series, double period_px);

}  // namespace reseau
