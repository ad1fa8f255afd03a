// Shorthands for the built-in sets under one CIE illuminant on the 5 nm grid. Pure, reentrant.
#pragma once

#include <string_view>

#include "core/color/primary_set.h"

namespace reseau {

// As element_xyz(), Bradford where a set of stated colours needs it. InputError for an unknown
// name.
[[nodiscard]] Matrix3 element_primaries(std::string_view name, Illuminant light);
// The same without adaptation.
[[nodiscard]] Matrix3 element_primaries_as_stated(std::string_view name, Illuminant light);

// Share of the picture's area that the red, green and blue elements cover; sums to 1. From the
// micrograph in core/color/data/dufaycolor_geometry.csv.
[[nodiscard]] Vector3 dufaycolor_areas();

}  // namespace reseau
