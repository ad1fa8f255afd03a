// RGB spaces given by chromaticities, linear sRGB and its curve, luminance and gamut. Pure
// functions, reentrant.
#pragma once

#include <optional>
#include <string_view>

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

// "srgb-linear", "display-p3", "rec2020", "prophoto" or "aces-ap0", from core/color/data; CHECK for
// any other word.
[[nodiscard]] Chromaticities rgb_space_chromaticities(std::string_view space);
[[nodiscard]] Chromaticities srgb_chromaticities();

// XYZ relative to the D65 of this project to linear RGB of a space, Bradford-adapted to the space's
// own white, so that white is exactly (1, 1, 1): D50 for ProPhoto, near D60 for ACES. The D65 of
// standards (0.3127, 0.3290) differs from ours by rounding, 2e-5 in x, y.
[[nodiscard]] Matrix3 rgb_from_xyz_d65(const Chromaticities& space);
[[nodiscard]] Matrix3 srgb_from_xyz_d65();

// What a file's RGB means: XYZ relative to our D65. `adopted_neutral` is the file's attribute of
// that name, the x, y that is to look neutral: colours are Bradford-adapted from it. A file without
// it is taken as relative to D65 already.
[[nodiscard]] Matrix3 xyz_d65_from_file(const Chromaticities& space,
                                        const std::optional<Chromaticity>& adopted_neutral);

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
// The same with a soft shoulder: what lies within 80 % of the way from grey to the border stays,
// all beyond is brought into the last fifth, farther colours nearer to the border, so that
// gradations of saturated colours survive. Luminance and dominant wavelength stay; no colour that
// sRGB has moves by more than 4.5 (CIEDE2000). Finite in, finite out. For view copies only.
[[nodiscard]] Rgb compress_into_gamut(const Rgb& rgb);

}  // namespace reseau
