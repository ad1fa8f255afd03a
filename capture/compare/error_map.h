// The colour difference as a picture with a scale.
#pragma once

#include <filesystem>

#include "capture/compare/compare.h"

namespace reseau::compare {

// By the ending of the name: .svg (squares of mean ΔE, a colour scale, a length bar, and arrows of
// the registration error where there is one) or .png (the same squares finer, colour scale and
// length bar below). The scale ends at the 99th percentile of the squares, or `full_scale` when
// that is above 0. Throws InputError for another ending or a name that is taken, std::system_error
// when it cannot be written. Same comparison, same bytes.
void write_error_map(const Comparison& comparison, double full_scale,
                     const std::filesystem::path& path);

// Throws the InputErrors of write_error_map that need no comparison.
void check_error_map_name(const std::filesystem::path& path);

}  // namespace reseau::compare
