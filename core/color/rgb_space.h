// RGB spaces given by chromaticities, linear sRGB and its curve, luminance and gamut. Pure
// functions, reentrant.
#pragma once

#include "core/color/colorimetry.h"

namespace reseau {

// CIE x, y of red, green, blue and white, for the `chromaticities` of an OpenEXR file.
struct Chromaticities {
  std::array<Chromaticity, 4> xy{};
};

using Rgb = Vector3;  // linear unless a name says otherwise

// XYZ (white Y = 1) of RGB (1, 1, 1 = white), as OpenEXR readers compute it. InputError when the
// four points define no space (three primaries on a line, y = 0, numbers not finite).
[[nodiscard]] Matrix3 xyz_from_rgb(const Chromaticities& space);

// IEC 61966-2-1 primaries and white (0.3127, 0.3290).
[[nodiscard]] Chromaticities srgb_chromaticities();

// XYZ relative to the D65 of this project to linear sRGB. The two D65 differ by rounding (2e-5 in
// x, y); Bradford adaptation between them makes the white exactly (1, 1, 1).
[[nodiscard]] Matrix3 srgb_from_xyz_d65();

// Encoding curve of IEC 61966-2-1, and back. Odd about 0, continued above 1: no clipping.
[[nodiscard]] double srgb_encode(double linear);
[[nodiscard]] double srgb_decode(double encoded);

// Y of linear sRGB.
[[nodiscard]] double srgb_luminance(const Rgb& rgb);
// Every component within 0..1.
[[nodiscard]] bool in_gamut(const Rgb& rgb);
// The nearest colour towards grey of the same luminance that lies within 0..1; luminance itself
// is clamped to 0..1 first. Colours already inside return unchanged. For view copies only.
[[nodiscard]] Rgb desaturate_into_gamut(const Rgb& rgb);

}  // namespace reseau
