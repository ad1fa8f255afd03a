// What of each picture is compared, and how its XYZ become CIELAB.
#pragma once

#include <stop_token>
#include <string>

#include "capture/compare/color_pass.h"
#include "capture/compare/compare.h"

namespace reseau::compare {

// "420 × 400".
[[nodiscard]] std::string size_text(const PictureHeader& header);

// The part of A that is compared; B's has the same size, moved by the offset. InputError when the
// sizes differ and nothing was chosen, when the crop lies outside, or when nothing is left.
[[nodiscard]] Rect area_of(const PictureHeader& a, const PictureHeader& b,
                           const CompareOptions& options);

// With the adaptation of the picture's own white where that was asked for.
[[nodiscard]] Side make_side(Picture& picture, const Rect& area, const CompareOptions& options);

// Fits B to A as asked for: into `color` and into the matrix of B. InputError when nothing fits.
void fit_sides(const Side& a, Side& b, const CompareOptions& options, ColorFigures& color,
               const std::stop_token& stop);

// After the fit: XYZ relative to D65 to those relative to the white of CIELAB.
void adapt_to_lab_white(Side& side, LabWhite white);

}  // namespace reseau::compare
