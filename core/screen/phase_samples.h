// Measurements of where the réseau lies: one per block of cells.
#pragma once

#include <vector>

#include "core/screen/cell_moments.h"
#include "core/screen/light_drift.h"
#include "core/screen/screen_map.h"
#include "core/screen/window_fit.h"

namespace reseau {

struct PhaseSample {
  Vec2 p_in_scan;                 // centre of the block's light
  Vec2 s_in_screen;               // unwrapped
  double info_u = 0, info_v = 0;  // inverse variances [1/periods^2], each with the other unknown
  // The same if the noise of the pixels were all that errs.
  double noise_info_u = 0, noise_info_v = 0;
  double modulation = 0;
};

// Blocks of the grid, side by side: `columns` cells (a multiple of 2; a CellGrid's gaps count too)
// by `rows` cells.
struct BlockShape {
  int columns = 2, rows = 4;
  // Cells beyond the block's borders on each side that are looked at while following the réseau.
  int reach = 0;
};

// Where a map puts the centre of every cell, mean over the cell [row][column].
[[nodiscard]] std::vector<Vec2> screen_at_cells(const CellGrid& cells, const ScreenMap& map);

// Measures every block of the cell rows [first_row, end_row) against a map that is right to a
// fraction of a period; `screen` is screen_at_cells() of that map. What the picture drags the
// pattern along through a blur of variance blur_px2 [px^2] is taken off. What is left of a line
// error is small; samples speak of the film under an ideal stage: p_in_scan is where that would see
// it.
[[nodiscard]] std::vector<PhaseSample> measure_samples(const CellGrid& cells, const ScreenMap& map,
                                                       const std::vector<Vec2>& screen,
                                                       const ColorSeries& series,
                                                       const BlockShape& shape,
                                                       const LightDrift& drift, double blur_px2);

// Series over all cells; `screen` is screen_at_cells() of the map they are seen under.
[[nodiscard]] bool pooled_series(const CellGrid& cells, const std::vector<Vec2>& screen,
                                 ColorSeries& series);

}  // namespace reseau
