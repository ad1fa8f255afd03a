// What makes a region unfit, or some of its pixels. Parts of measure_edge.
#pragma once

#include <span>
#include <vector>

#include "calibration/edge/measure_edge.h"
#include "calibration/edge/pixel_fit.h"

namespace reseau {

// Marks pixels that lie far off the prediction for their distance (dust, hot pixels), with their
// neighbours where several meet. Within near_px of the edge the prediction is trusted to
// `tolerance` of the contrast only, beyond to a tenth of that. Returns how many are marked in all;
// `used` is row by row.
std::size_t leave_out_strays(Span2D<const float> samples, std::span<unsigned char> used,
                             const PixelModel& model, const ProfileFunction& profile,
                             double tolerance, double near_px);

struct ClipFinding {
  bool clipped = false;
  double share = 0;  // of pixels at the value where they pile up
};
// `width_px`: Gaussian width of the edge, `noise`: of a sample, in its units.
[[nodiscard]] ClipFinding find_clipping(Span2D<const float> samples, const PixelModel& model,
                                        const EdgeOptions& options, double width_px, double noise);

// Share of the area near the edge whose mean lies off the prediction by more than `tolerance` of
// the contrast, beyond noise.
[[nodiscard]] double uneven_share(Span2D<const float> samples, const PixelModel& model,
                                  const ProfileFunction& profile, double tolerance, double noise);

// Share of the whole region, more than near_px away from the line, that is neither as dark as the
// dark side nor as bright as the bright one is to be, by more than 0.4 of the contrast: another
// edge lies there. Of a large region some pixels stand for all.
[[nodiscard]] double other_level_share(Span2D<const float> samples, const PixelModel& model,
                                       double near_px, double noise);

}  // namespace reseau
