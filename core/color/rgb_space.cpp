#include "core/color/rgb_space.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/color/adaptation.h"
#include "core/color/tables.h"

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

Chromaticities rgb_space_chromaticities(std::string_view space) {
  const auto table = rgb_space_table();
  const auto row = std::find_if(table.begin(), table.end(),
                                [space](const RgbSpaceRow& r) { return r.space == space; });
  CHECK(row != table.end());
  return {{{{row->red_x, row->red_y},
            {row->green_x, row->green_y},
            {row->blue_x, row->blue_y},
            {row->white_x, row->white_y}}}};
}

Chromaticities srgb_chromaticities() { return rgb_space_chromaticities("srgb-linear"); }

Matrix3 rgb_from_xyz_d65(const Chromaticities& space) {
  return multiply(inverse(xyz_from_rgb(space)),
                  bradford_target_from_source(white_of(Illuminant::kD65),
                                              xyz_from_chromaticity(space.xy[3], 1.0)));
}

Matrix3 srgb_from_xyz_d65() { return rgb_from_xyz_d65(srgb_chromaticities()); }

Matrix3 xyz_d65_from_file(const Chromaticities& space,
                          const std::optional<Chromaticity>& adopted_neutral) {
  const Matrix3 xyz = xyz_from_rgb(space);
  if (!adopted_neutral) return xyz;
  return multiply(bradford_target_from_source(xyz_from_chromaticity(*adopted_neutral, 1.0),
                                              white_of(Illuminant::kD65)),
                  xyz);
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

namespace {

// Share of the way from `grey` to `rgb` that lies within 0..1; above 1 for colours inside.
double way_to_border(const Rgb& rgb, double grey) {
  double way = std::numeric_limits<double>::infinity();
  for (const double v : rgb) {
    if (v > grey) {
      way = std::min(way, (1 - grey) / (v - grey));
    } else if (v < grey) {
      way = std::min(way, grey / (grey - v));
    }
  }
  return way;
}

// Within 0..1, and never -0, which the way to the border would be divided by.
double grey_of(double luminance) { return std::min(std::max(0.0, luminance), 1.0); }

Rgb towards_grey(const Rgb& rgb, double grey, double keep) {
  Rgb out{};
  for (std::size_t i = 0; i < 3; ++i) {
    out[i] = std::clamp(grey + keep * (rgb[i] - grey), 0.0, 1.0);
  }
  return out;
}

}  // namespace

Rgb desaturate_into_gamut(const Rgb& rgb) {
  if (in_gamut(rgb)) {
    return rgb;
  }
  const double grey = grey_of(srgb_luminance(rgb));
  return towards_grey(rgb, grey, std::min(1.0, way_to_border(rgb, grey)));
}

Rgb compress_into_gamut(const Rgb& rgb) {
  constexpr double kShoulder = 0.8;
  const double luminance = srgb_luminance(rgb);
  const double grey = grey_of(luminance);
  const double distance = 1 / way_to_border(rgb, grey);  // 1 on the border
  if (distance <= kShoulder && luminance == grey) return rgb;
  if (!std::isfinite(distance)) return {grey, grey, grey};
  const double beyond = std::max(0.0, distance - kShoulder) / (1 - kShoulder);
  const double kept = std::min(distance, kShoulder) + (1 - kShoulder) * beyond / (1 + beyond);
  return towards_grey(rgb, grey, distance > 0 ? kept / distance : 1.0);
}

}  // namespace reseau
