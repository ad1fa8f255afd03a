// Sharpness from one slanted edge: modulation transfer with honest uncertainty, or the reasons why
// there is none. Pure, reentrant.
//
// Line and curvature of the edge, levels, shading, optics and what optics leave over are fitted to
// the pixels themselves by maximum likelihood: no bins of a quarter pixel, no finite differences,
// no window. Samples must be linear in light; the aperture of the pixel belongs to the result.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "calibration/edge/edge_line.h"
#include "calibration/edge/line_places.h"
#include "calibration/edge/mtf_curve.h"
#include "calibration/edge/optics.h"
#include "calibration/edge/profile_bins.h"
#include "core/base/span2d.h"

namespace reseau {

enum class EdgeStatus {
  kOk,
  kDoubtful,  // figures are given; the reasons say what they rest on
  kRefused,   // no figures
};
[[nodiscard]] const char* name(EdgeStatus status);

enum class EdgeReason {
  // Refusals.
  kTooSmall,
  kNotFinite,
  kNoContrast,
  kNotAnEdge,
  kCurved,
  kClipped,
  kTooWide,
  kShortPlateau,
  kNoFit,
  // Doubts.
  kPhaseCoverage,
  kNotReached,
  kUneven,
  // Remarks.
  kLeftOut,
  kShading,
  kBent,
  kCorrelatedNoise,
  kResidual,
};
// The code of JSON, "no-contrast"; and a sentence for people.
[[nodiscard]] const char* code(EdgeReason reason);
[[nodiscard]] const char* sentence(EdgeReason reason);
[[nodiscard]] EdgeStatus severity(EdgeReason reason);

struct EdgeOptions {
  // Light within +-window_px makes up the windowed curve.
  double window_px = 28;
  // Ends of the scale: samples there may be clipped. Infinite = unknown.
  double lowest = -std::numeric_limits<double>::infinity();
  double highest = std::numeric_limits<double>::infinity();
  double quantum = 0;         // step of the samples; 0 = unknown
  bool with_profile = false;  // fill EdgeMeasurement::profile, bins and places
};

struct ProfilePlotPoint {
  double d_px = 0;
  double measured = 0, n = 0;  // mean of the samples there, levels taken off, and their number
  double esf = 0, lsf = 0;
};

struct EdgeMeasurement {
  EdgeStatus status = EdgeStatus::kRefused;
  std::vector<EdgeReason> reasons;
  [[nodiscard]] bool has(EdgeReason reason) const;

  // Of the region, whose first pixel has its centre at (0, 0). Known as far as the work came.
  EdgeLine line;
  double angle_deg = 0;   // to the nearer axis of the grid, 0..45
  double normal_deg = 0;  // direction in which it gets brighter, from +x towards +y, -180..180
  double offset_sd_px = 0, angle_sd_deg = 0;
  double length_px = 0;
  double reach_px = 0;  // farther pixels were not looked at
  double dark = 0, bright = 0;
  double dark_shading = 0, bright_shading = 0;  // across, change over the reach / contrast
  double along_shading = 0;                     // change over half the length / contrast
  double noise = 0;                             // of one sample / contrast
  double clipped = 0, left_out = 0;             // shares of the pixels
  double wander_px = 0;     // of the edge from line to line, beyond noise, rms; it was taken out
  double phase_gap_px = 0;  // widest gap between samples near the edge

  MtfOfEdge mtf;  // empty when refused
  EdgeOptics optics;
  std::vector<int> optics_parameters;
  std::vector<double> optics_sd;
  double residual_share = 0;  // posterior probability that optics alone do not explain the edge
  std::vector<ProfilePlotPoint> profile;
  std::vector<ProfileBins::Bin> bins;  // what the profile was fitted to
  std::vector<LinePlace> places;       // of each line of pixels, in order
};

// Never throws for anything in the samples; NaN and infinities are left out.
[[nodiscard]] EdgeMeasurement measure_edge(Span2D<const float> samples,
                                           const EdgeOptions& options = {});

}  // namespace reseau
