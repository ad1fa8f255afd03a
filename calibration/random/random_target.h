// The whole spread of a point of light in two dimensions, from a target of square cells that are
// clear or opaque by chance. Pure, reentrant.
//
// The spread function is a cubic spline with a knot every 1 / per_px px; what a pixel sees of the
// cells through it is exact (cells and spline are piecewise polynomials). Where the target lies and
// how it is scaled and turned is fitted together with it; the middle of the spread is the target's
// place.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/span2d.h"
#include "core/geometry/vec2.h"

namespace reseau {

// Whether cell (column, row) is clear. Columns and rows may be negative.
[[nodiscard]] bool random_cell(std::uint64_t seed, std::int64_t column, std::int64_t row);

struct RandomTarget {
  std::uint64_t seed = 1;
  double cell_px = 0.5;  // side of a cell; its corner (0, 0) is the target's origin
};

struct RandomOptions {
  int support_px = 7;  // of the spread, odd
  int per_px = 2;      // knots
  int most_px = 128;   // side of the part in the middle that is used
  // Where the picture's first pixel lies in the target, to within `search_px`.
  Vec2 start_px;
  int search_px = 24;
};

struct RandomPsf {
  bool ok = false;
  std::string why;  // a sentence, when not ok

  int side = 0;  // samples along an axis, 1 / per_px apart, the middle one at (0, 0)
  double step_px = 0.5;
  std::vector<double> psf;    // [row][column], per px squared; the integral is 1
  std::vector<double> sd;     // of each
  double sd_of_all = 0;       // root of the summed variances over the root of the summed squares
  double smallest_share = 0;  // of the curvature's eigenvalues, of the largest: the rank
  // target = origin + scale (x, y) about the middle of the part that was used.
  Vec2 origin_px, origin_sd_px;
  Mat2 scale{1, 0, 0, 1};
  double dark = 0, contrast = 0, noise = 0;  // noise of a sample, of the contrast
  // Modulus of the transfer function at a frequency [cycles/px].
  [[nodiscard]] double mtf(double fx, double fy) const;
};

[[nodiscard]] RandomPsf measure_random(Span2D<const float> samples, const RandomTarget& target,
                                       const RandomOptions& options = {});

}  // namespace reseau
