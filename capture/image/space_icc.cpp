#include "capture/image/space_icc.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "capture/image/lcms_handles.h"
#include "core/base/check.h"
#include "core/base/error.h"
#include "core/color/adaptation.h"

namespace reseau {
namespace {

// s15Fixed16Number of ICC.1, and the white of the PCS in it: 0.9642, 1.0, 0.8249.
constexpr double kOne = 65536;
constexpr std::array<double, 3> kPcsWhite = {0xF6D6 / kOne, 1, 0xD32D / kOne};
// Largest magnitude that is written; the format ends at 32768.
constexpr double kMostColorant = 1000;

// Rounded to the steps of the file. Where the columns add up to the white of the PCS before, they
// do so after: the largest of a row takes what rounding left.
Matrix3 rounded_colorants(const Matrix3& m) {
  Matrix3 out{};
  for (std::size_t row = 0; row < 3; ++row) {
    double sum = 0, rounded_sum = 0;
    std::size_t largest = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double value = m[3 * row + i] * kOne;
      sum += value;
      out[3 * row + i] = std::round(value);
      rounded_sum += out[3 * row + i];
      if (std::abs(value) > std::abs(m[3 * row + largest] * kOne)) largest = i;
    }
    out[3 * row + largest] += std::round(sum) - rounded_sum;
    for (std::size_t i = 0; i < 3; ++i) out[3 * row + i] /= kOne;
  }
  return out;
}

LcmsCurve curve_of(const IccEncoding& encoding) {
  if (encoding.kind == IccEncoding::Kind::kSrgb) {
    // IEC 61966-2-1: ((x + 0.055) / 1.055)^2.4 above 0.04045, x / 12.92 below.
    constexpr std::array<double, 5> kSrgb = {2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045};
    return LcmsCurve(cmsBuildParametricToneCurve(nullptr, 4, kSrgb.data()));
  }
  const double gamma = encoding.kind == IccEncoding::Kind::kGamma ? encoding.gamma : 1;
  return LcmsCurve(cmsBuildGamma(nullptr, gamma));
}

std::string encoding_words(const IccEncoding& encoding) {
  switch (encoding.kind) {
    case IccEncoding::Kind::kSrgb:
      return "sRGB curve";
    case IccEncoding::Kind::kGamma: {
      std::array<char, 32> text{};
      const auto end = std::to_chars(text.data(), text.data() + text.size(), encoding.gamma).ptr;
      return "gamma " + std::string(text.data(), end);
    }
    default:
      return "linear";
  }
}

// ASCII of a name that a person may have chosen.
std::string ascii(const std::string& text) {
  std::string out;
  for (const char c : text) out += c >= ' ' && c <= '~' ? c : '_';
  return out;
}

}  // namespace

IccEncoding parse_icc_encoding(std::string_view word) {
  if (word == "linear") return {};
  if (word == "srgb") return {IccEncoding::Kind::kSrgb, 1};
  double gamma = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), gamma);
  if (error != std::errc() || end != word.data() + word.size() || !(gamma >= 0.1 && gamma <= 10)) {
    throw InputError("There is no curve '" + std::string(word) +
                     "'; use linear, srgb, or a gamma from 0.1 to 10.");
  }
  return {IccEncoding::Kind::kGamma, gamma};
}

std::vector<std::byte> matrix_icc(const Matrix3& xyz_d65_from_rgb, const IccEncoding& encoding,
                                  const std::string& description) {
  const Matrix3 pcs_from_d65 =
      bradford_target_from_source(white_of(Illuminant::kD65), Xyz{kPcsWhite});
  const Matrix3 pcs_from_rgb = multiply(pcs_from_d65, xyz_d65_from_rgb);
  const bool usable = std::all_of(pcs_from_rgb.begin(), pcs_from_rgb.end(), [](double v) {
    return std::isfinite(v) && std::abs(v) <= kMostColorant;
  });
  if (!usable || !(condition_number(pcs_from_rgb) < 1e6)) {
    throw InputError(
        "No colour profile can hold these primaries: they lie too far out or on one "
        "line.");
  }
  const LcmsProfile profile(cmsCreateProfilePlaceholder(nullptr));
  CHECK(profile != nullptr);
  void* const p = profile.get();
  cmsSetProfileVersion(p, 4.3);
  cmsSetDeviceClass(p, cmsSigDisplayClass);
  cmsSetColorSpace(p, cmsSigRgbData);
  cmsSetPCS(p, cmsSigXYZData);
  cmsSetHeaderRenderingIntent(p, INTENT_RELATIVE_COLORIMETRIC);
  write_icc_text(profile, cmsSigProfileDescriptionTag, ascii(description));
  write_icc_text(profile, cmsSigCopyrightTag, "No rights reserved.");
  const cmsCIEXYZ white = {kPcsWhite[0], kPcsWhite[1], kPcsWhite[2]};
  CHECK(cmsWriteTag(p, cmsSigMediaWhitePointTag, &white));
  CHECK(cmsWriteTag(p, cmsSigChromaticAdaptationTag, pcs_from_d65.data()));
  const Matrix3 colorants = rounded_colorants(pcs_from_rgb);
  constexpr std::array kColorants = {cmsSigRedColorantTag, cmsSigGreenColorantTag,
                                     cmsSigBlueColorantTag};
  for (std::size_t i = 0; i < 3; ++i) {
    const cmsCIEXYZ xyz = {colorants[i], colorants[3 + i], colorants[6 + i]};
    CHECK(cmsWriteTag(p, kColorants[i], &xyz));
  }
  const LcmsCurve curve = curve_of(encoding);
  CHECK(curve != nullptr && cmsWriteTag(p, cmsSigRedTRCTag, curve.get()) &&
        cmsLinkTag(p, cmsSigGreenTRCTag, cmsSigRedTRCTag) &&
        cmsLinkTag(p, cmsSigBlueTRCTag, cmsSigRedTRCTag));
  return reproducible_icc(profile);
}

std::vector<std::byte> picture_icc(const ColorRecipe& recipe, const IccEncoding& encoding) {
  // The white balance is in the picture's numbers, not in what they mean.
  ColorRecipe plain = recipe;
  plain.white_balance = {1, 1, 1};
  const ColorModel model = make_color_model(plain);
  const bool of_film = recipe.space == OutputSpace::kProcess || recipe.space == OutputSpace::kFilm;
  return matrix_icc(multiply(model.xyz_from_process, inverse(model.output_from_process)), encoding,
                    "reseau " + space_word(recipe.space) +
                        (of_film ? " " + recipe.primaries.name : "") + ", " +
                        encoding_words(encoding));
}

}  // namespace reseau
