// From phase samples to a map of the whole frame.
#pragma once

#include <vector>

#include "core/screen/map_uncertainty.h"
#include "core/screen/phase_samples.h"
#include "core/screen/screen_map.h"
#include "core/screen/spline_surface.h"

namespace reseau {

struct MapFit {
  ScreenMap map;
  double residual_px = 0;  // weighted rms of the inliers
  int n_used = 0;
  int n_outliers = 0;
  bool usable = false;
  SurfaceLevels levels;  // of the splines in use
  // For MapUncertainty: the samples as they were weighed in the end, and what they leave.
  std::vector<PlacedInfo> placed;
  MapErrorModel error_model;
};

// How a fit comes by its levels.
struct LevelPlan {
  const SurfaceLevels* start = nullptr;  // taken in the first of the robust rounds
  int n_choices = 2;                     // rounds after it in which left-out blocks choose anew
};

// Robust affine map, and where held-out blocks of samples prove that it is better, a displacement
// by cubic B-splines from coarse to fine whose levels those blocks choose. Needs at least 6
// samples.
// Levels finer than finest_px are not tried, and none where the affine map leaves less than
// flat_px.
[[nodiscard]] MapFit fit_map(const std::vector<PhaseSample>& samples, int width_px, int height_px,
                             double finest_px, double flat_px, const LevelPlan& plan = {});

}  // namespace reseau
