// What a set of primaries can show, against sRGB. Pure, reentrant.
#pragma once

#include "core/color/matrix3.h"

namespace reseau {

struct GamutFigures {
  double area_xy = 0;         // of the triangle in x, y
  double area_of_srgb = 0;    // the same over that of sRGB; may exceed 1
  double coverage = 0;        // share of the triangle of sRGB inside this one, 0..1
  double volume = 0;          // CIELAB volume of all intensities 0..1, white D65, Y = 1
  double volume_of_srgb = 0;  // over that of sRGB
};

// Of the matrix from intensities 0..1 to XYZ relative to D65. All zero for primaries on a line.
[[nodiscard]] GamutFigures gamut_of(const Matrix3& xyz_from_rgb);

}  // namespace reseau
