// The error of the stage from what blocks of a few lines measured.
#pragma once

#include <vector>

#include "core/screen/line_error.h"

namespace reseau {

// How far a strip of a few lines lies from where a map without this error puts it.
struct LineSample {
  Vec2 p_in_scan;
  Vec2 off_px;                    // of the film under the strip
  double info_x = 0, info_y = 0;  // inverse variances [1/px^2]
};

struct LineFit {
  LineError error;    // none unless the strips prove it
  double gain = 0;    // how much better strips left out are predicted [nats per strip]
  double rms_px = 0;  // of the error over the lines
  double sd_px = 0;   // of the error's own uncertainty, rms over the lines
};

// Tries errors that depend on the line (axis kLines) from stiff to loose. Every other strip must
// predict those between clearly better than no error does, and the other way round, or there is
// none. strip_px: length of a strip, across the axis; strips lie side by side from 0. extent_px: of
// the scan along the axis. Deterministic.
[[nodiscard]] LineFit fit_line_error(const std::vector<LineSample>& strips, LineError::Axis axis,
                                     double strip_px, double extent_px, double finest_px);

// Fits once more with the spacing of `known`, adding to it.
[[nodiscard]] LineError improve_line_error(const std::vector<LineSample>& strips,
                                           const LineError& known);

}  // namespace reseau
