#include "calibration/edge/measure_edge.h"

namespace reseau {
namespace {

struct ReasonText {
  EdgeReason reason;
  EdgeStatus severity;
  const char* code;
  const char* sentence;
};

constexpr ReasonText kReasons[] = {
    {EdgeReason::kTooSmall, EdgeStatus::kRefused, "too-small",
     "The region is too small: an edge needs at least 10 x 10 pixels."},
    {EdgeReason::kNotFinite, EdgeStatus::kRefused, "not-finite",
     "Too many samples of the region are not numbers."},
    {EdgeReason::kNoContrast, EdgeStatus::kRefused, "no-contrast",
     "No edge rises out of the noise of the region."},
    {EdgeReason::kNotAnEdge, EdgeStatus::kRefused, "not-one-edge",
     "The region does not hold one single edge between two flat areas."},
    {EdgeReason::kCurved, EdgeStatus::kRefused, "curved", "The edge is too curved."},
    {EdgeReason::kClipped, EdgeStatus::kRefused, "clipped",
     "One side of the edge is clipped: expose so that neither side reaches the end of the scale."},
    {EdgeReason::kTooWide, EdgeStatus::kRefused, "too-wide",
     "The transition is too wide for the region: choose a wider region."},
    {EdgeReason::kShortPlateau, EdgeStatus::kRefused, "short-plateau",
     "The edge has no flat area on both sides within the region."},
    {EdgeReason::kNoFit, EdgeStatus::kRefused, "no-fit", "The edge could not be fitted."},
    {EdgeReason::kPhaseCoverage, EdgeStatus::kDoubtful, "phase-coverage",
     "The edge runs along the pixel grid, which samples its profile at few places: the figures "
     "rest "
     "on the physical model alone."},
    {EdgeReason::kNotReached, EdgeStatus::kDoubtful, "mtf50-not-reached",
     "The transfer stays above one half up to one cycle per pixel."},
    {EdgeReason::kUneven, EdgeStatus::kDoubtful, "uneven", "The areas beside the edge are uneven."},
    {EdgeReason::kLeftOut, EdgeStatus::kOk, "pixels-left-out",
     "Dust, hot pixels or samples that are no numbers were left out."},
    {EdgeReason::kShading, EdgeStatus::kOk, "shading",
     "The light changes across the edge; it was fitted."},
    {EdgeReason::kBent, EdgeStatus::kOk, "bent", "The edge is bent; its curvature was fitted."},
    {EdgeReason::kCorrelatedNoise, EdgeStatus::kOk, "correlated-noise",
     "The noise is correlated; the uncertainty takes it into account."},
    {EdgeReason::kResidual, EdgeStatus::kOk, "beyond-physics",
     "Lens, aperture and blur alone do not explain the profile; a free residual was added."},
};

const ReasonText& text_of(EdgeReason reason) {
  for (const ReasonText& text : kReasons) {
    if (text.reason == reason) return text;
  }
  return kReasons[0];
}

}  // namespace

const char* name(EdgeStatus status) {
  switch (status) {
    case EdgeStatus::kOk:
      return "ok";
    case EdgeStatus::kDoubtful:
      return "doubtful";
    default:
      return "refused";
  }
}

const char* code(EdgeReason reason) { return text_of(reason).code; }
const char* sentence(EdgeReason reason) { return text_of(reason).sentence; }
EdgeStatus severity(EdgeReason reason) { return text_of(reason).severity; }

}  // namespace reseau
