// ICC v4 profiles of our own for every space a picture can be in, through lcms2: the same bytes
// each time. All functions are thread-safe.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "core/color/element_color.h"

namespace reseau {

// How the samples that a profile describes are encoded.
struct IccEncoding {
  enum class Kind { kLinear, kSrgb, kGamma } kind = Kind::kLinear;
  double gamma = 1;  // kGamma: linear = sample^gamma
};
// "linear", "srgb" or a gamma from 0.1 to 10; InputError otherwise.
[[nodiscard]] IccEncoding parse_icc_encoding(std::string_view word);

// A matrix profile (ICC.1:2010, version 4.3; class display, PCS XYZ) with exactly these colorants:
// `xyz_d65_from_rgb` is Bradford-adapted from our D65 to the white of the PCS. Where (1, 1, 1) is
// D65, the rounded colorants still add up to the white of the PCS to the last bit. (1, 1, 1) need
// not be white: clear film of the balance `brightness` keeps its cast. InputError for a matrix that
// is singular or not finite.
[[nodiscard]] std::vector<std::byte> matrix_icc(const Matrix3& xyz_d65_from_rgb,
                                                const IccEncoding& encoding,
                                                const std::string& description);

// The profile of a picture made by a recipe, in the space it is in.
[[nodiscard]] std::vector<std::byte> picture_icc(const ColorRecipe& recipe,
                                                 const IccEncoding& encoding);

}  // namespace reseau
