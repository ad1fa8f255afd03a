// CIELAB and the CIEDE2000 colour difference. Pure functions, reentrant.
#pragma once

#include <array>

#include "core/color/colorimetry.h"

namespace reseau {

using Lab = std::array<double, 3>;  // L* 0..100, a*, b*

// CIE 1976 L*a*b* against `white` (all components positive, CHECK). Negative XYZ count as 0; values
// above the white are not clipped. Both pictures of a comparison take the same white: D65.
[[nodiscard]] Lab lab_from_xyz(const Xyz& xyz, const Xyz& white);

// CIEDE2000 with kL = kC = kH = 1 (Sharma, Wu and Dalal 2005, whose 34 pairs it reproduces to four
// decimals). Symmetric, never negative; NaN when an argument holds NaN.
[[nodiscard]] double delta_e_2000(const Lab& first, const Lab& second);

// What a set of differences comes to. The largest `worst_fraction` (rounded to whole samples) is
// left out of mean, 95th percentile and maximum, as in Hubicka et al. 2025 (there 0.01).
struct DeltaESummary {
  double mean = 0;
  double p95 = 0;
  double max = 0;
  std::size_t n = 0;  // samples that counted
};
// Sorts the samples in place; they must not hold NaN. All zero when nothing is left.
[[nodiscard]] DeltaESummary summarize_delta_e(std::span<double> samples, double worst_fraction);

}  // namespace reseau
