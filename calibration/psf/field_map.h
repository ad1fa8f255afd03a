// How the blur of a unit changes over its frame: a smooth surface through what single edges show.
// Pure, reentrant.
#pragma once

#include <optional>
#include <span>

#include "calibration/edge/optics.h"
#include "calibration/profile/records.h"

namespace reseau {

// One edge: where it is, -1 to 1 over the frame, and the Gaussian variance [px^2] that it has on
// top of the model that all edges share.
struct FieldSample {
  double x = 0, y = 0, value = 0, sd = 0;
};

// What an edge has on top of `shared`, from where its transfer falls to one half.
[[nodiscard]] std::optional<Measured> extra_variance(const EdgeOptics& shared,
                                                     const NormalCosines& normal,
                                                     double mtf50_cy_per_px, double mtf50_sd,
                                                     double slope);

// Constant, plane or quadratic surface, as many terms as the samples ask for (BIC); deviations grow
// where the surface misses them by more than they claim. Nothing without samples.
[[nodiscard]] std::optional<FieldRecord> fit_field(std::span<const FieldSample> samples);

}  // namespace reseau
