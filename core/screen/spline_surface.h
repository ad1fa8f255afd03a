// A smooth scalar surface over the frame, fitted to scattered values from coarse to fine.
#pragma once

#include <vector>

#include "core/geometry/vec2.h"

namespace reseau {

// Cubic B-splines on a square grid: coefficient (i, j) sits at ((i - 1) * spacing, (j - 1) *
// spacing).
struct SplineSurface {
  double spacing_px = 0;
  int n_columns = 0, n_rows = 0;
  std::vector<double> coefficients;  // [row][column]

  [[nodiscard]] double at(Vec2 p) const;
};

struct ScatteredValues {
  std::vector<Vec2> positions;  // in the frame [px]
  std::vector<double> values;
  std::vector<double> weights;  // inverse variances; 0 = left out
};

struct SurfaceLevels {
  std::vector<double>
      spacing_px;  // coarse to fine, each half of the one before; the finest is kept
  // Per level: stiffness of the correction that this level adds, or a negative number for none.
  std::vector<double> stiffness;
  [[nodiscard]] bool flat() const;
};

// Side of the blocks that are left out together, for levels down to finest_px: so large that a
// sample left out shares no pixel with one that was fitted but at their rim, and no larger than
// what the finest level can bridge [px].
[[nodiscard]] double left_out_block_px(double finest_px);
// Whether a place lies in a block of this fold, 0..4: a fifth of all.
[[nodiscard]] bool left_out_of_fold(Vec2 p, int fold, double block_px);

// Levels for a frame, all still undecided: the coarsest about the size of the frame, each next half
// of it, the finest not below finest_px.
[[nodiscard]] SurfaceLevels surface_levels(int width_px, int height_px, double finest_px);

// Decides level by level, by blocks of samples left out of the fit, whether a correction at that
// level predicts them better than none, and how stiff it should be. Positions are those of the
// first coordinate. Deterministic.
void choose_levels(const std::vector<const ScatteredValues*>& coordinates, int width_px,
                   int height_px, SurfaceLevels& levels);

// Fits with the levels chosen: each corrects what the coarser ones left. Where there are no samples
// the surface is that of the coarser levels, never an extrapolation of the finer.
[[nodiscard]] SplineSurface fit_surface(const ScatteredValues& samples, int width_px, int height_px,
                                        const SurfaceLevels& levels);

}  // namespace reseau
