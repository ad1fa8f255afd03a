// From samples as a file holds them to XYZ relative to D65. Immutable, thread-safe.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/color/colorimetry.h"

namespace reseau::compare {

class ColorDecode {
 public:
  virtual ~ColorDecode() = default;
  // [pixel][3] each; the two may be the same memory. NaN stays NaN.
  virtual void to_xyz(std::span<const float> samples, std::span<float> xyz) const = 0;
};

// Linear samples through one matrix.
[[nodiscard]] std::unique_ptr<ColorDecode> linear_decode(const Matrix3& xyz_from_samples);
// Curve of sRGB, then a matrix.
[[nodiscard]] std::unique_ptr<ColorDecode> srgb_curve_decode(const Matrix3& xyz_from_linear);
// sample^gamma, then a matrix.
[[nodiscard]] std::unique_ptr<ColorDecode> gamma_decode(double gamma,
                                                        const Matrix3& xyz_from_linear);
// Through an ICC profile, relative colorimetric: its white becomes D65. Nothing when the profile is
// damaged or not of RGB; `why` then says so in a sentence.
[[nodiscard]] std::unique_ptr<ColorDecode> icc_decode(std::span<const std::byte> icc,
                                                      std::string& why);

// XYZ (D65 of this project) from linear sRGB.
[[nodiscard]] Matrix3 xyz_from_linear_srgb();

}  // namespace reseau::compare
