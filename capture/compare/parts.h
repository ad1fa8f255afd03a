// Resolution and registration of two opened pictures.
#pragma once

#include "capture/compare/color_pass.h"
#include "capture/compare/compare.h"

namespace reseau::compare {

// Sets `resolution` or `no_resolution` of the result. InputError when the region that was asked for
// lies outside the compared area.
void compare_resolution(const Side& a, const Side& b, const ColorPass& pass,
                        const CompareOptions& options, Comparison& result);

// Sets `registration` or `no_registration`. InputError for a map that does not fit its picture.
void compare_registration(const CompareOptions& options, Comparison& result);

}  // namespace reseau::compare
