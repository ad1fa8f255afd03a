// Measurements of where the réseau lies: one per window of cells.
#pragma once

#include <vector>

#include "core/screen/cell_moments.h"
#include "core/screen/screen_map.h"
#include "core/screen/window_fit.h"

namespace reseau {

struct PhaseSample {
  Vec2 p_in_scan;
  Vec2 s_in_screen;               // unwrapped
  double info_u = 0, info_v = 0;  // inverse variances [1/periods^2], each with the other unknown
  double modulation = 0;
};

struct WindowShape {
  int stride_cells = 2;
  double sigma_cells = 1.0;
};

// Follows the réseau from the seed outwards, window by window, surest first. The result is
// connected, so that no sample is off by a whole period.
[[nodiscard]] std::vector<PhaseSample> grow_samples(const CellGrid& cells, Vec2 seed_px,
                                                    Vec2 screen_at_seed, const ColorSeries& series,
                                                    const WindowShape& shape);

// Measures every window against a map that is right to a fraction of a period. Blur moves the
// pattern up the slope of the brightness s: a mask m seen through a blur of variance b [px^2] is
// h * (s m) = s (h * m) + b grad(s) . grad(h * m) + ..., the mask b grad(ln s) away. With blur_px2
// = b that drift is taken off.
[[nodiscard]] std::vector<PhaseSample> measure_samples(const CellGrid& cells, const ScreenMap& map,
                                                       const ColorSeries& series,
                                                       const WindowShape& shape, double blur_px2);

// Variance of the blur that explains the amplitudes of a series best, a step of 0.05 px in its
// root [px^2].
[[nodiscard]] double pattern_blur_px2(const ColorSeries& series, const ScreenMap& map);

// Series over all cells under a map.
[[nodiscard]] bool pooled_series(const CellGrid& cells, const ScreenMap& map, ColorSeries& series);

}  // namespace reseau
