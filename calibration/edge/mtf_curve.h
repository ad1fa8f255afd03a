// Modulation transfer with its uncertainty, out of a fitted edge profile.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "calibration/edge/profile_fit.h"

namespace reseau {

struct MtfPoint {
  double f_cy_per_px = 0, value = 0, sd = 0;
};

struct MtfCrossing {
  double f_cy_per_px = 0, sd = 0;
};

struct MtfCurve {
  std::vector<MtfPoint> points;  // 0, 0.01 … 1 cycles per pixel
  // Where the curve first falls below 50, 30 and 10 %; nothing when it does not up to 1.
  std::optional<MtfCrossing> mtf50, mtf30, mtf10;
};

inline constexpr double kMtfStepCyPerPx = 0.01;

// One sample for the covariance: where it lies, its residual and the line of pixels it belongs to.
struct ProfileSample {
  double distance = 0, value = 0, weight = 1;
  int line = 0;
};

struct MtfOfEdge {
  // All light, with the tails of the physical model beyond what the region shows.
  MtfCurve all;
  // Only what lies within +-window_px of the edge, as windowed methods see it.
  MtfCurve window;
  double window_px = 0;
  // Standard deviation over the one that white noise would give, and the correlation of
  // neighbouring lines.
  double inflation = 1, line_correlation = 0;
};

// `samples` in the order of their lines. The covariance takes all noise within a line of pixels,
// and correlation between neighbouring lines, as it finds it.
[[nodiscard]] MtfOfEdge transfer_of(const ProfileFit& fit, std::span<const ProfileSample> samples,
                                    double window_px);

}  // namespace reseau
