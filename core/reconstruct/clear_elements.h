// How a scanner without infrared answers to clear film: the directions of the three answers are
// known from the réseau, how bright clear film is has to be read off the picture.
#pragma once

#include <stop_token>

#include "core/line/line_source.h"
#include "core/reconstruct/reconstruct.h"
#include "core/reconstruct/tone_curve.h"
#include "core/screen/lattice_hypothesis.h"
#include "core/screen/screen_pattern.h"

namespace reseau {

// Scales the answer to each element so that the brightest silver seen behind it counts as clear:
// that of one pixel in a thousand amid the elements, on an even grid of some 500,000 pixels. What
// is clipped is brighter than all else. Pixels that show no one element (light beside the film,
// dust) are left out. Where too few pixels tell, the brightest answer of all counts as full scale.
// `response` must be regular. Pure, reentrant.
void scale_to_clear(const LineSource& source, const Registration& registration,
                    const ToneCurves& tone, const ScreenPattern& pattern,
                    const std::stop_token& stop, Response& response);

}  // namespace reseau
