// How certain a map is at a place.
#pragma once

#include <cmath>
#include <vector>

#include "core/geometry/vec2.h"
#include "core/screen/screen_map.h"

namespace reseau {

// Covariance of the place where the map puts a point of the film [px^2].
struct PlaceCovariance {
  double xx = 0, xy = 0, yy = 0;
  [[nodiscard]] Vec2 sd() const { return {std::sqrt(xx), std::sqrt(yy)}; }
};

// One measured phase, as far as certainty goes: where, and its inverse variances [1/periods^2].
struct PlacedInfo {
  Vec2 p_in_scan;
  double info_u = 0, info_v = 0;
  double noise_info_u = 0, noise_info_v = 0;  // if the noise of the pixels were all that errs
};

// What is known of a map's errors besides the samples.
struct MapErrorModel {
  // Variance of the residuals over the variance that the samples claim, per screen coordinate.
  double excess_u = 1, excess_v = 1;
  double spacing_px = 0;         // of the finest spline in use; 0 = affine
  double amplitude_periods = 0;  // rms of what splines added, the most that can be missing
};

// Covariances of the film on a grid over the frame, bilinear between, and of the stage line by
// line. Immutable value.
class MapUncertainty {
 public:
  MapUncertainty() = default;
  MapUncertainty(const ScreenMap& map, const std::vector<PlacedInfo>& samples,
                 const MapErrorModel& model, int width_px, int height_px);

  [[nodiscard]] bool empty() const { return covariance_.empty(); }
  [[nodiscard]] PlaceCovariance at(Vec2 p_in_scan) const;
  // Root mean square of the standard deviation over the frame, both axes together [px].
  [[nodiscard]] double rms_px() const;
  // The Cramér-Rao bound of this model of the film if all that the fits of the windows leave were
  // noise of the pixels, rms over the frame, both axes together [px]. Where the scene leaves more
  // than the noise does, it lies above the true bound. Without what the stage adds.
  [[nodiscard]] double bound_px() const { return bound_px_; }
  // Of the mean slope of u and of v along x and y [periods/px], rows as in a Jacobian.
  [[nodiscard]] const Mat2& slope_sd() const { return slope_sd_; }

 private:
  int n_columns_ = 0, n_rows_ = 0;
  double step_x_ = 1, step_y_ = 1;
  std::vector<PlaceCovariance> covariance_;  // of the film alone
  LineError stage_;
  double bound_px_ = 0;
  Mat2 slope_sd_{0, 0, 0, 0};
};

}  // namespace reseau
