// A Gaussian blur that changes across a frame, which no focus of the simulated lens makes.
#pragma once

#include <cstdint>
#include <span>

#include "core/line/line_format.h"

namespace reseau {

// Widens the samples [line][plane][pixel] by a Gaussian whose variance is what `first_px` lacks to
// a standard deviation that grows evenly from first_px at the first column to last_px at the last,
// and adds noise of `noise` of full scale. The same input gives the same samples.
void blur_across(const LineFormat& format, double first_px, double last_px, double noise,
                 std::span<std::uint16_t> samples);

}  // namespace reseau
