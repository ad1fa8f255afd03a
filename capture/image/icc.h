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
  // The profile is a table: the samples must go through IccTable::to_linear_light() first.
  bool through_table = false;
  std::string note;  // a sentence: what was found and done
};

// Curves of a matrix profile of RGB, or what is to be done for one that is a table. A profile that
// is damaged or not of RGB is taken as linear and the note says so; never throws for its contents.
[[nodiscard]] IccTone tone_of_icc(std::span<const std::byte> icc);

}  // namespace reseau
