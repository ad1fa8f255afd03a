// The plots of the colour chain. Pure; text and pixels only, files are the caller's.
#pragma once

#include <string>
#include <vector>

#include "core/color/element_color.h"

namespace reseau {

// One triangle of the chromaticity diagram.
struct DiagramTriangle {
  std::string name;
  Matrix3 xyz{};  // columns: the elements
  Chromaticity white{};
};

// CIE 1931 x, y: the spectral locus with wavelengths, the triangles with their whites, sRGB dashed.
[[nodiscard]] std::string chromaticity_svg(const std::string& title,
                                           const std::vector<DiagramTriangle>& triangles);

struct TransmittanceCurve {
  std::string name;
  std::string color;  // "#rrggbb"
  Spectrum transmittance;
  // The readings; beyond them the curve is only continued, and drawn dashed.
  double read_from_nm = 380, read_to_nm = 780;
};
// 380..780 nm, 0..100 %, the names below.
[[nodiscard]] std::string transmittance_svg(const std::string& title,
                                            const std::vector<TransmittanceCurve>& curves);
// The three elements of a set with spectra.
[[nodiscard]] std::vector<TransmittanceCurve> element_curves(const PrimarySet& set,
                                                             const DyeState& dyes);

// Both beside each other; only the diagram for a set without spectra.
[[nodiscard]] std::string primary_set_svg(const ColorRecipe& recipe);

// Linear sRGB of the elements, red green blue columns, brought into 0..1 by one common exposure and
// compression of what sRGB does not have. `balanced`: the balance of the recipe counts.
[[nodiscard]] Matrix3 element_srgb(const ColorRecipe& recipe);

// The réseau of Dufaycolor, `periods` periods of red lines high and wide, turned by 23 degrees.
[[nodiscard]] std::string reseau_svg(const std::string& title, const Matrix3& element_srgb,
                                     int periods);
// The same as 8-bit sRGB pixels, side x side, each the mean of 4 x 4 points.
[[nodiscard]] std::vector<unsigned char> reseau_pixels(const Matrix3& element_srgb, int periods,
                                                       int side_px);

}  // namespace reseau
