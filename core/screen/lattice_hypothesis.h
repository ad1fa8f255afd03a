// Which lattice, which way round, which element is which: hypotheses about a candidate pair of
// frequencies, judged on raw harmonic amplitudes of several tiles. Never on ratios of channels:
// where the scene is saturated a ratio looks like another screen.
#pragma once

#include <array>
#include <vector>

#include "core/screen/cell_moments.h"
#include "core/screen/linear_rows.h"
#include "core/screen/screen_layout.h"

namespace reseau {

// Scanner response to each clear element per unit silver, [element R G B][channel R G B].
using Response = std::array<std::array<double, 3>, 3>;

struct TileCorner {
  int x = 0, y = 0;  // in the block of rows
};

struct LatticeHypothesis {
  ScreenLayout layout = ScreenLayout::kLinesAndSquares;
  int special_color = 0;       // of the lines, or of what lies between two sites
  Carriers carriers;           // u along the lines; right-handed: cross(u, v) > 0; of the tile
  Carriers mean_carriers;      // of all tiles
  double explained = 0;        // share of what alternates in the tiles, all channels, 0..1
  double other_explained = 0;  // the most that the other layout explains
  bool colors_fit = false;     // one site is red, one green, one blue, as screens were made
  Vec2 center_px;              // of the tile that shows the pattern best, in the block
  Vec2 screen_at_center;
  Response response{};  // without infrared only the directions are known, sizes are relative
  double sigma_px = 0;  // the best of a few blurs
};

// Tries every layout and both assignments of the pair (a, b) to (u, v) with each tile's own
// frequencies and phase, and returns the best. `tile_carriers`: the pair near each tile. Without
// infrared the plane of the silver is ignored.
[[nodiscard]] LatticeHypothesis judge_lattice(const LinearRows& rows,
                                              const std::vector<TileCorner>& tiles,
                                              const std::vector<Carriers>& tile_carriers,
                                              int tile_size, bool infrared);

}  // namespace reseau
