// From linear light to the samples of a view copy, and the exposure that shows a picture well.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace reseau {

// sRGB transfer curve (IEC 61966-2-1) of a linear value, 0 for negative and NaN, 1 above 1.
[[nodiscard]] double srgb_encoded(double linear);

// Counts luminances of a picture to find a percentile. The answer depends on the pixels only, not
// on their order; it is the upper edge of a bin 0.8 % wide.
class LuminanceHistogram {
 public:
  // `rgb`: [pixel][3], linear sRGB after `srgb_from_picture` (row-major 3x3). Not finite or
  // negative luminances count as 0.
  explicit LuminanceHistogram(const std::array<double, 9>& srgb_from_picture);
  void add(std::span<const float> rgb);
  // The value that a fraction q (0..1) of the pixels does not exceed; 0 without pixels.
  [[nodiscard]] double percentile(double q) const;

 private:
  std::array<float, 3> weights_;
  std::vector<std::uint64_t> counts_;
};

// What becomes of colours that sRGB does not have, in view copies only; the EXR keeps all.
enum class ViewGamut {
  kClip,        // each component to 0..1
  kPerceptual,  // compress_into_gamut(): luminance kept, saturation compressed towards the border
};
// "clip" or "perceptual"; InputError otherwise.
[[nodiscard]] ViewGamut parse_view_gamut(std::string_view word);

// Turns linear pixels into samples: matrix, exposure, gamut, sRGB curve, rounding to nearest.
// Immutable, thread-safe.
class ViewEncoder {
 public:
  ViewEncoder(const std::array<double, 9>& srgb_from_picture, double exposure,
              ViewGamut gamut = ViewGamut::kClip);
  // [pixel][3] each. Returns how many pixels lay outside (a component outside 0..1 by more than
  // half an 8-bit step, or not finite) and were clipped or compressed.
  std::uint64_t encode(std::span<const float> rgb, std::span<std::uint16_t> out) const;
  std::uint64_t encode(std::span<const float> rgb, std::span<std::uint8_t> out) const;

 private:
  template <typename Sample>
  std::uint64_t encode_as(std::span<const float> rgb, std::span<Sample> out) const;
  std::array<float, 9> matrix_;
  ViewGamut gamut_;
};

}  // namespace reseau
