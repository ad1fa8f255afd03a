// What a blur of a given width does to a spatial frequency.
#pragma once

#include <limits>

#include "core/geometry/vec2.h"

namespace reseau {

// The shape of a point spread function whose width may change over the frame. Plain value; the
// default is a round Gaussian.
struct BlurShape {
  // Width in focus, a Gaussian [px, standard deviation]: what a blur is wider than that, is a disc
  // of defocus.
  double in_focus_px = std::numeric_limits<double>::infinity();
  // Variance along x over the mean of both axes is 1 + stretch, along y 1 - stretch.
  double stretch = 0;
  // Of the light, what goes farther than the pattern repeats: evenly everywhere.
  double far_share = 0;

  // Optical transfer at f [cycles/px] of a blur of sigma_px, the standard deviation along an axis,
  // mean of the variances of both. Negative where a disc reverses contrast.
  [[nodiscard]] double transfer(Vec2 f, double sigma_px) const;

  bool operator==(const BlurShape&) const = default;
};

}  // namespace reseau
