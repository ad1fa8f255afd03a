// The best linear estimate of a colour from the silver around a pixel. Through the blurred réseau
// every pixel holds a known mixture of three intensities; what is believed of pictures (neighbours
// are alike, brightness varies more than colour) and the noise decide the rest. Collection,
// saturation loss and interpolation are one solve, and where the blur has taken the colour away the
// estimate falls back to its surroundings instead of raising noise.
#pragma once

#include <span>
#include <vector>

#include "core/geometry/vec2.h"
#include "core/reconstruct/blurred_cell.h"
#include "core/reconstruct/radial_covariance.h"

namespace reseau {

struct EstimatorSettings {
  Mat2 screen_from_scan;  // linear part [periods/px]
  double sigma_px = 0;    // blur, pixel aperture included; that of the cell
  double stretch = 0;     // of that blur, as BlurShape
  double noise_sd = 0;    // of a pixel's silver over the light there
  int radius_px = 6;      // of the square of pixels that is looked at
  // Of light that alternates along the line (red in a Dufaycolor), more beside one kind of square
  // than beside the other, and is not the picture's: no estimate follows it.
  double line_alternation_sd = 0;
  int line_color = 0;
};

// What is to be estimated: a colour at a place relative to the middle pixel [px].
struct EstimatorTarget {
  int color = 0;
  Vec2 offset_px;
};

// Immutable, thread-safe.
class LocalEstimator {
 public:
  // The cell must outlive the estimator.
  LocalEstimator(const BlurredCell& cell, const EstimatorSettings& settings);

  [[nodiscard]] int side_px() const { return 2 * settings_.radius_px + 1; }
  // Weights of the pixels of the square, [target][row][pixel], when the middle one lies at
  // `middle` [periods].
  [[nodiscard]] std::vector<double> weights(Vec2 middle,
                                            std::span<const EstimatorTarget> targets) const;

 private:
  const BlurredCell& cell_;
  EstimatorSettings settings_;
  RadialCovariance brightness_, brightness_seen_, color_, color_seen_;
};

}  // namespace reseau
