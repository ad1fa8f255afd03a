#include "core/color/rgb_space.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/color/adaptation.h"

namespace reseau {
namespace {
// Beyond this no useful colour could be told from rounding.
constexpr double kWorstCondition = 1e6;
}  // namespace

Matrix3 xyz_from_rgb(const Chromaticities& space) {
  const Xyz white = xyz_from_chromaticity(space.xy[3], 1.0);
  // A primary may have y = 0 (XYZ itself has two), so it is built from x, y, z, not from Y.
  const auto point = [&space](std::size_t i) -> Vector3 {
    const Chromaticity& c = space.xy[i];
    return {c[0], c[1], 1 - c[0] - c[1]};
  };
  const Matrix3 directions = from_columns(point(0), point(1), point(2));
  if (!(condition_number(directions) < kWorstCondition)) {
    throw InputError("The three primaries lie on one line and cannot make colours; use others.");
  }
  return scale_columns(directions, multiply(inverse(directions), white));
}

Chromaticities srgb_chromaticities() {
  return {{{{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}, {0.3127, 0.3290}}}};
}

Matrix3 srgb_from_xyz_d65() {
  const Chromaticities srgb = srgb_chromaticities();
  const Xyz srgb_white = xyz_from_chromaticity(srgb.xy[3], 1.0);
  return multiply(inverse(xyz_from_rgb(srgb)),
                  bradford_target_from_source(white_of(Illuminant::kD65), srgb_white));
}

double srgb_encode(double linear) {
  const double v = std::abs(linear);
  const double e = v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
  return std::copysign(e, linear);
}

double srgb_decode(double encoded) {
  const double e = std::abs(encoded);
  const double v = e <= 0.04045 ? e / 12.92 : std::pow((e + 0.055) / 1.055, 2.4);
  return std::copysign(v, encoded);
}

double srgb_luminance(const Rgb& rgb) {
  static const Matrix3 xyz = xyz_from_rgb(srgb_chromaticities());
  return xyz[3] * rgb[0] + xyz[4] * rgb[1] + xyz[5] * rgb[2];
}

bool in_gamut(const Rgb& rgb) {
  return std::all_of(rgb.begin(), rgb.end(), [](double v) { return v >= 0 && v <= 1; });
}

Rgb desaturate_into_gamut(const Rgb& rgb) {
  if (in_gamut(rgb)) {
    return rgb;
  }
  const double grey = std::clamp(srgb_luminance(rgb), 0.0, 1.0);
  double keep = 1;  // share of the distance from grey that still fits
  for (const double v : rgb) {
    if (v > 1) {
      keep = std::min(keep, (1 - grey) / (v - grey));
    } else if (v < 0) {
      keep = std::min(keep, grey / (grey - v));
    }
  }
  Rgb out{};
  for (std::size_t i = 0; i < 3; ++i) {
    out[i] = std::clamp(grey + keep * (rgb[i] - grey), 0.0, 1.0);
  }
  return out;
}

}  // namespace reseau
