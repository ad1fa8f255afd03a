// The whole spread of a point of light in two dimensions, from a target of square cells that are
// clear or opaque by chance. Pure, reentrant.
//
// The spread function is a cubic spline with a knot every 1 / per_px px; what a pixel sees of the
// cells through it is exact (cells and spline are piecewise polynomials). Where the target lies,
// how it is scaled, turned and slightly bent, and how the light changes, is fitted together with
// it. A shift of the target and one of the spread are the same: the spread's middle, where a
// Gaussian matches it best, is taken as the place.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "calibration/random/random_cells.h"
#include "core/base/span2d.h"
#include "core/geometry/vec2.h"

namespace reseau {

enum class RandomStatus {
  kOk,
  kTooSmall,       // fewer than 48 pixels a side
  kNoSamples,      // not numbers, or clipped, for the most part
  kNoContrast,     // all alike
  kOtherTarget,    // does not look like the target of this seed and cell size
  kNotTold,        // the cells repeat the pixels: rank deficient
  kTooFewSamples,  // fewer samples than the spread has knots, twice over
};
// Machine-readable, as in JSON; a sentence a person can act on.
[[nodiscard]] const char* code(RandomStatus status);
[[nodiscard]] const char* sentence(RandomStatus status);

struct RandomOptions {
  int support_px = 9;                     // of the spread
  int per_px = 2;                         // knots
  int most_px = 128;                      // side of the part in the middle that is used
  double lowest = -1e30, highest = 1e30;  // samples at these ends are clipped
};

struct RandomPsf {
  RandomStatus status = RandomStatus::kOk;
  [[nodiscard]] bool ok() const { return status == RandomStatus::kOk; }

  // Along the scan's axes: samples 1 / per_px apart, the middle one at (0, 0); per px squared, the
  // integral of the whole spline is 1.
  int side = 0;
  double step_px = 0.5;
  std::vector<double> psf;   // [row][column]
  std::vector<double> sd;    // of each
  double relative_sd = 0;    // root of the summed variances over the root of the summed squares
  double weakest_share = 0;  // smallest curvature by a knot's pattern over the largest: the rank
  // target = origin + scale (x, y) + bend, (x, y) from the middle of the part that was used; target
  // from its own middle [px].
  Vec2 middle_px;  // of the part, in the picture
  Vec2 origin_px, origin_sd_px;
  Mat2 scale;
  double bend_px = 0;   // the largest at the borders of the part
  double turn_deg = 0;  // of the target against the scan's axes
  bool mirrored = false;
  double dark = 0, contrast = 0;
  double noise = 0;     // of a sample, of the contrast: what the model leaves over
  double left_out = 0;  // share of the samples that were clipped or no numbers
  int side_used_px = 0;

  // Light beyond the support, which a lens throws there by its cut-off: from the shape of the
  // transfer within. 0 with a deviation of 0 where that cannot be told.
  double outside = 0, outside_sd = 0;
  double diffraction_px = 0, diffraction_sd = 0;  // 1 / cut-off

  // The modulus of the transfer function, pixel aperture included, f in cycles/px: of the spread
  // within its support; of all light.
  struct Point {
    double value = 0, sd = 0;
  };
  [[nodiscard]] Point mtf(double fx, double fy) const;
  [[nodiscard]] Point mtf_of_all(double fx, double fy) const;
  // Where that of all light falls to one half along a direction; 0 where it does not below 1
  // cycle/px.
  [[nodiscard]] Point mtf50(double direction_rad) const;

  struct Fit;
  std::shared_ptr<const Fit> fit;  // knots with covariance
};

// `start`: what another channel of the same picture gave; spares the search.
[[nodiscard]] RandomPsf measure_random(Span2D<const float> samples, const RandomCells& cells,
                                       const RandomOptions& options = {},
                                       const RandomPsf* start = nullptr);

}  // namespace reseau
