// The three elements of Dufaycolor as colours: printed spectra or chromaticities, and the area that
// each element covers. Pure functions, reentrant.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/color/colorimetry.h"

namespace reseau {

// Sets that `--primaries` knows; the first is the default, "cornwell-clyne-1951".
[[nodiscard]] std::vector<std::string> primary_set_names();

// XYZ of the full red, green and blue element (columns) under a light whose own Y is 1, area not
// counted. Spectra are integrated under the light on the 5 nm grid; sets of chromaticities are
// Bradford-adapted from the illuminant they were stated for. InputError for an unknown name,
// listing the known ones.
[[nodiscard]] Matrix3 element_primaries(std::string_view name, Illuminant light);

// The same without adaptation: chromaticities as printed; spectra under `light` as above.
[[nodiscard]] Matrix3 element_primaries_as_stated(std::string_view name, Illuminant light);

// Share of the picture's area that the red, green and blue elements cover; sums to 1. From the
// micrograph in core/color/data/dufaycolor_geometry.csv.
[[nodiscard]] Vector3 dufaycolor_areas();

}  // namespace reseau
