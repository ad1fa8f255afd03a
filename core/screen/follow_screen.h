// From a seed and the cells of a frame to the map of the whole frame.
#pragma once

#include <optional>
#include <vector>

#include "core/screen/cell_moments.h"
#include "core/screen/lattice_search.h"
#include "core/screen/line_error.h"
#include "core/screen/map_fit.h"

namespace reseau {

struct FollowedScreen {
  MapFit fit;
  double line_gain = 0;  // evidence for the line error [nats per strip]
  double coverage = 0;   // of the blocks that have light, how many were measured
  // The réseau bends too sharply for these cells; smaller ones would follow it.
  bool needs_smaller_cells = false;
  int cell_px = 0;  // width of the cells that it was followed through
  // Of film that bends within a tile: the blocks of 8 x 8 px [row][column] that the map was fitted
  // to; elsewhere little is claimed. Empty: all.
  std::vector<bool> trusted;
  bool settled = false;  // another pass along the map adds nothing
  // rms of blocks under a map, line error and film, that was fitted without them: across the lines
  // of equal u and of equal v [px]. Absent unless asked for.
  std::optional<Vec2> left_out_px;
};

[[nodiscard]] FollowedScreen follow_screen(const CellGrid& cells, const LatticeSeed& seed,
                                           bool check_left_out = false);
// The same from a usable map of such film onwards, through cells whose harmonics run along that
// map. `pass` counts how often, from 0 to kPassesAlong - 1.
inline constexpr CellSize kSmallCells{8, 8};
inline constexpr int kMostPassesAlong = 6;
[[nodiscard]] FollowedScreen follow_along(const CellGrid& cells, const LatticeSeed& seed,
                                          const FollowedScreen& known, bool check_left_out);

// Cells, and how many columns of them are kept, for a frame. `exact` keeps all of any frame.
[[nodiscard]] int keep_every_for(int width_px, int height_px, bool exact);

}  // namespace reseau
