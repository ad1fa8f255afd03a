// How much two sets of primaries differ on given colours. Pure, reentrant.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/color/delta_e.h"
#include "core/color/element_color.h"

namespace reseau {

// What a difference is measured against; the defaults are those of Hubicka et al. 2025.
struct DifferenceConvention {
  enum class LabWhite {
    kD65,     // one white for both pictures; the cast of a réseau counts
    kReseau,  // each picture against its own clear réseau; casts are forgiven
  };
  LabWhite white = LabWhite::kD65;
  double worst_fraction = 0.01;  // left out, of the mean too
  bool clamp_xyz = false;        // X, Y and Z to 0..1 first, as Color-Screen does
};

// CIEDE2000 between the colours that two models make of the same element intensities.
[[nodiscard]] DeltaESummary set_difference(std::span<const Vector3> intensities,
                                           const ColorModel& a, const ColorModel& b,
                                           const DifferenceConvention& convention);

// Stated sets of element intensities: "warm" and "green", 1000 log-normal triples each on Halton
// points, seven parameters fitted to what Hubicka et al. 2025 publish for the photographs of their
// Fig. 6 and Fig. 3; "even", 1000 Halton points of the cube 0..1. InputError for another word.
[[nodiscard]] std::vector<Vector3> stated_colors(std::string_view name);

// Rank correlation (Spearman), mean ranks for ties; NaN for fewer than two values.
[[nodiscard]] double spearman(std::span<const double> a, std::span<const double> b);

}  // namespace reseau
