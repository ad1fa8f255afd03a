// Modulation transfer of one straight edge between two flat areas, from its pixels. Pure,
// reentrant.
//
// The edge spread is a cubic spline of the distance to the edge (knots 0.25 px apart), fitted to
// the unsmoothed pixels with a roughness penalty that grows away from the edge and is chosen by
// generalised cross-validation; angle and position are refined by least squares on the same pixels.
// The transfer function is the closed-form transform of the spline: no bins of a quarter pixel, no
// finite differences, no window. Pixel aperture and everything else before the samples belong to
// it. Light that spreads beyond `support_px` is not seen.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace reseau::compare {

struct EdgeGeometry {
  double normal_deg = 0;  // direction across the edge, from +x towards +y
  double offset_px = 0;   // of the edge along the normal from the middle of the region
};

struct EdgeMtf {
  // "ok", or why there is no figure: "too-small", "no-contrast", "not-an-edge", "not-flat",
  // "angle" (the edge runs along the pixel grid, so that its profile is not sampled finely enough).
  std::string status = "ok";
  std::string reason;  // a sentence; empty when ok
  [[nodiscard]] bool ok() const { return status == "ok"; }

  EdgeGeometry geometry;
  double angle_deg = 0;     // of the edge to the nearer axis of the pixel grid, 0..45
  double length_px = 0;     // of the edge within the region
  double support_px = 0;    // pixels farther from the edge than this were not used
  double contrast = 0;      // between the plateaus, in units of the samples
  double residual = 0;      // rms of samples about the fitted profile, fraction of the contrast
  std::vector<double> mtf;  // at 0, 0.01 ... 1 cycles per pixel; 1 at 0
  std::optional<double> mtf50_cy_per_px;  // absent when it stays above one half up to 1
};

inline constexpr double kMtfStep = 0.01;

// `samples` [row][column] in linear light; NaN is left out. `start` spares the search of the angle.
[[nodiscard]] EdgeMtf measure_edge(std::span<const double> samples, int width_px, int height_px,
                                   const std::optional<EdgeGeometry>& start = {});

}  // namespace reseau::compare
