// Where a region most plausibly falls into two flat halves: a first guess at its edge.
#pragma once

#include <optional>

#include "calibration/edge/edge_line.h"
#include "core/base/span2d.h"

namespace reseau {

struct FirstLine {
  EdgeLine line;
  double cell_px = 1;  // of what was looked at: the guess is as coarse as this
  double dark = 0, bright = 0;
  double explained = 0;  // share of the variance that two flat halves explain
};

// The line for which two constants leave the least squares, over all angles and places; NaN is left
// out. Nothing when the region is constant or has fewer than 16 finite samples. Takes one pass over
// the samples, whatever their number.
[[nodiscard]] std::optional<FirstLine> first_line(Span2D<const float> samples);

}  // namespace reseau
