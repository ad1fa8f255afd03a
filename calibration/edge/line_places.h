// Where each line of pixels sees the edge: two channels of one scan are held against each other
// line by line, so that a blade or a stage that wavers drops out. Part of measure_edge.
#pragma once

#include <span>
#include <vector>

#include "calibration/edge/edge_line.h"
#include "calibration/edge/mtf_curve.h"
#include "calibration/edge/profile_fit.h"

namespace reseau {

struct LinePlace {
  int line = 0;         // row of the region, or column where the edge runs along x
  double at_px = 0;     // where the edge crosses it, along the line
  double variance = 0;  // [px^2] across the edge, of white noise
  // [px^2] The same for all lines: the place of the best line and the middle of the profile differ
  // where noise or the profile is not as supposed.
  double common = 0;
};

// `shifts`: of each line, as it was taken out of the distances of `samples`; empty = none. The
// place is where the fitted profile, mirrored, matches itself best.
[[nodiscard]] std::vector<LinePlace> line_places(std::span<const ProfileSample> samples,
                                                 const ProfileFit& fit, const EdgeLine& line,
                                                 std::span<const double> shifts, double width_px);

// How far the edge of `b` lies from that of `a` along the normal, from the lines that both have.
struct PlaceDifference {
  double value = 0, variance = 0;  // of white noise
  double common = 0;               // variance that lines do not show
  double chi2 = 0, freedom = 0;    // of parts of the edge about the mean: how white it is
};
[[nodiscard]] PlaceDifference place_difference(std::span<const LinePlace> a,
                                               std::span<const LinePlace> b, double normal_rad);

}  // namespace reseau
