// ICC profiles through lcms2: our own, the same bytes each time, and the tone curves of other
// people's. All functions are thread-safe.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "core/reconstruct/tone_curve.h"

namespace reseau {

// RGB with linear curves for masters. Its primaries are those of sRGB for want of better: no scan
// has told us the primaries of the scanner; the description of the profile says so.
[[nodiscard]] std::vector<std::byte> linear_scanner_icc();
// sRGB for view copies.
[[nodiscard]] std::vector<std::byte> srgb_icc();

struct IccTone {
  ToneCurves curves = ToneCurves::linear();  // R G B from the profile, infrared linear
  bool linear = true;                        // the curves are straight to 1e-5
  std::string note;                          // a sentence: what was found and done
};

// Curves of an RGB profile: those of a matrix profile as they are; of a table (LUT) profile the
// luminance of its neutral axis, the same for the three channels, as the note says. A profile that
// is damaged or not of RGB is taken as linear and the note says so; never throws for its contents.
[[nodiscard]] IccTone tone_of_icc(std::span<const std::byte> icc);

}  // namespace reseau
