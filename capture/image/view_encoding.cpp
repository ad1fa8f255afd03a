#include "capture/image/view_encoding.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <string>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/color/rgb_space.h"

namespace reseau {
namespace {

// A positive float's upper 16 bits: exponent and 7 bits of mantissa.
constexpr std::size_t kHistogramBins = 32768;
// Half an 8-bit step outside 0..1, through the slope of the sRGB curve there (12.92 and 0.4396).
constexpr float kLowestShown = static_cast<float>(-0.5 / 255 / 12.92);
constexpr float kHighestShown = static_cast<float>(1 + 0.5 / 255 / 0.4396);

// sRGB curve from 2^-16 to 1 in pieces that are straight over 1/512 of an octave's start: the error
// of 1e-7 is far below a 16-bit step. Below lies the straight part of the curve itself.
constexpr std::uint32_t kTableShift = 14;  // mantissa bits between two entries
constexpr std::uint32_t kTableBegin = 111u << 23 >> kTableShift;  // 2^-16
constexpr std::uint32_t kTableEnd = 127u << 23 >> kTableShift;    // 1

std::vector<float> make_curve() {
  std::vector<float> table;
  for (std::uint32_t i = kTableBegin; i <= kTableEnd + 1; ++i) {
    const auto linear = std::bit_cast<float>(i << kTableShift);
    table.push_back(static_cast<float>(srgb_encoded(static_cast<double>(linear))));
  }
  return table;
}

float encoded(float linear) {
  static const std::vector<float> curve = make_curve();
  if (!(linear > 0)) return 0;  // NaN as well
  if (linear >= 1) return 1;
  const auto bits = std::bit_cast<std::uint32_t>(linear);
  const std::uint32_t index = bits >> kTableShift;
  if (index < kTableBegin) return 12.92F * linear;
  constexpr std::uint32_t kFraction = (1u << kTableShift) - 1;
  const float t = static_cast<float>(bits & kFraction) / static_cast<float>(kFraction + 1);
  const float low = curve[index - kTableBegin];
  return low + t * (curve[index - kTableBegin + 1] - low);
}

std::array<float, 3> compressed(const std::array<float, 3>& v) {
  if (!std::isfinite(v[0]) || !std::isfinite(v[1]) || !std::isfinite(v[2])) return v;
  const Rgb rgb = compress_into_gamut({double{v[0]}, double{v[1]}, double{v[2]}});
  return {static_cast<float>(rgb[0]), static_cast<float>(rgb[1]), static_cast<float>(rgb[2])};
}

}  // namespace

double srgb_encoded(double linear) {
  if (!(linear > 0)) return 0;
  if (linear >= 1) return 1;
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

LuminanceHistogram::LuminanceHistogram(const std::array<double, 9>& srgb_from_picture)
    : weights_{}, counts_(kHistogramBins) {
  // Second row of the matrix from linear sRGB to XYZ (IEC 61966-2-1).
  constexpr std::array<double, 3> kLuminance = {0.2126, 0.7152, 0.0722};
  for (std::size_t column = 0; column < 3; ++column) {
    double weight = 0;
    for (std::size_t row = 0; row < 3; ++row) {
      weight += kLuminance[row] * srgb_from_picture[3 * row + column];
    }
    weights_[column] = static_cast<float>(weight);
  }
}

void LuminanceHistogram::add(std::span<const float> rgb) {
  CHECK(rgb.size() % 3 == 0);
  for (std::size_t i = 0; i < rgb.size(); i += 3) {
    const float y = weights_[0] * rgb[i] + weights_[1] * rgb[i + 1] + weights_[2] * rgb[i + 2];
    const bool counts = y > 0 && y <= std::numeric_limits<float>::max();
    ++counts_[counts ? std::bit_cast<std::uint32_t>(y) >> 16 : 0];
  }
}

double LuminanceHistogram::percentile(double q) const {
  std::uint64_t total = 0;
  for (const auto count : counts_) total += count;
  if (total == 0) return 0;
  const double wanted = std::clamp(q, 0.0, 1.0) * static_cast<double>(total);
  std::uint64_t below = 0;
  for (std::size_t bin = 0; bin < counts_.size(); ++bin) {
    below += counts_[bin];
    if (below == 0 || static_cast<double>(below) < wanted) continue;
    if (bin == 0) return 0;
    return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bin + 1) << 16));
  }
  return 0;
}

ViewGamut parse_view_gamut(std::string_view word) {
  if (word == "clip") return ViewGamut::kClip;
  if (word == "perceptual") return ViewGamut::kPerceptual;
  throw InputError("There is no handling of colours '" + std::string(word) +
                   "'; use clip or perceptual.");
}

ViewEncoder::ViewEncoder(const std::array<double, 9>& srgb_from_picture, double exposure,
                         ViewGamut gamut)
    : matrix_{}, gamut_(gamut) {
  for (std::size_t i = 0; i < matrix_.size(); ++i) {
    matrix_[i] = static_cast<float>(srgb_from_picture[i] * exposure);
  }
}

template <typename Sample>
std::uint64_t ViewEncoder::encode_as(std::span<const float> rgb, std::span<Sample> out) const {
  CHECK(rgb.size() % 3 == 0 && out.size() == rgb.size());
  constexpr auto kScale = static_cast<float>(std::numeric_limits<Sample>::max());
  std::uint64_t n_clipped = 0;
  for (std::size_t i = 0; i < rgb.size(); i += 3) {
    bool clipped = false;
    std::array<float, 3> v{};
    for (std::size_t row = 0; row < 3; ++row) {
      const float* m = matrix_.data() + 3 * row;
      v[row] = m[0] * rgb[i] + m[1] * rgb[i + 1] + m[2] * rgb[i + 2];
      clipped |= !(v[row] >= kLowestShown && v[row] <= kHighestShown);
    }
    if (gamut_ == ViewGamut::kPerceptual) v = compressed(v);
    for (std::size_t row = 0; row < 3; ++row) {
      // NOLINTNEXTLINE(bugprone-incorrect-roundings): never negative, and lround costs a call
      out[i + row] = static_cast<Sample>(encoded(v[row]) * kScale + 0.5F);
    }
    n_clipped += clipped ? 1 : 0;
  }
  return n_clipped;
}

std::uint64_t ViewEncoder::encode(std::span<const float> rgb, std::span<std::uint16_t> out) const {
  return encode_as(rgb, out);
}

std::uint64_t ViewEncoder::encode(std::span<const float> rgb, std::span<std::uint8_t> out) const {
  return encode_as(rgb, out);
}

}  // namespace reseau
