#include "capture/image/icc.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "capture/image/icc_table.h"
#include "capture/image/lcms_handles.h"
#include "core/base/check.h"

namespace reseau {
namespace {

constexpr std::size_t kEntries = 65536;
using Tables = std::array<std::vector<float>, 4>;

bool is_straight(const std::vector<float>& table) {
  for (std::size_t i = 0; i < table.size(); ++i) {
    if (std::abs(static_cast<double>(table[i]) - static_cast<double>(i) / 65535.0) > 1e-5) {
      return false;
    }
  }
  return true;
}

bool all_finite(const std::vector<float>& table) {
  return std::ranges::all_of(table, [](float value) { return std::isfinite(value); });
}

std::optional<Tables> matrix_curves(const LcmsProfile& profile) {
  Tables tables;
  constexpr std::array<cmsTagSignature, 3> kTags = {cmsSigRedTRCTag, cmsSigGreenTRCTag,
                                                    cmsSigBlueTRCTag};
  for (std::size_t c = 0; c < kTags.size(); ++c) {
    const auto* curve = static_cast<const cmsToneCurve*>(cmsReadTag(profile.get(), kTags[c]));
    if (curve == nullptr) return std::nullopt;
    tables[c].resize(kEntries);
    for (std::size_t i = 0; i < kEntries; ++i) {
      tables[c][i] = cmsEvalToneCurveFloat(curve, static_cast<float>(i) / 65535.0F);
    }
    if (!all_finite(tables[c])) return std::nullopt;
  }
  return tables;
}

}  // namespace

std::vector<std::byte> linear_scanner_icc() {
  const cmsCIExyY white = {0.3127, 0.3290, 1.0};
  const cmsCIExyYTRIPLE primaries = {{0.64, 0.33, 1.0}, {0.30, 0.60, 1.0}, {0.15, 0.06, 1.0}};
  const LcmsCurve straight(cmsBuildGamma(nullptr, 1.0));
  CHECK(straight != nullptr);
  cmsToneCurve* curves[3] = {straight.get(), straight.get(), straight.get()};
  const LcmsProfile profile(cmsCreateRGBProfile(&white, &primaries, curves));
  CHECK(profile != nullptr);
  write_icc_text(profile, cmsSigProfileDescriptionTag,
                 "reseau linear scanner RGB (primaries not measured)");
  return reproducible_icc(profile);
}

std::vector<std::byte> srgb_icc() {
  const LcmsProfile profile(cmsCreate_sRGBProfile());
  CHECK(profile != nullptr);
  return reproducible_icc(profile);
}

IccTone tone_of_icc(std::span<const std::byte> icc) {
  IccTone tone;
  const LcmsProfile profile(
      cmsOpenProfileFromMem(icc.data(), static_cast<cmsUInt32Number>(icc.size())));
  if (profile == nullptr) {
    tone.note = "The embedded colour profile is damaged; the samples are taken as linear.";
    return tone;
  }
  if (cmsGetColorSpace(profile.get()) != cmsSigRgbData) {
    tone.note = "The embedded colour profile is not one of RGB; the samples are taken as linear.";
    return tone;
  }
  if (IccTable::open(icc) != nullptr) {
    const auto root = ToneCurves::gamma(2), straight = ToneCurves::linear();
    tone.curves = ToneCurves({root.table(0), root.table(1), root.table(2), straight.table(3)});
    tone.linear = false;
    tone.through_table = true;
    tone.note =
        "The embedded colour profile is a table: red, green and blue are turned into linear light "
        "through it; infrared is taken as linear.";
    return tone;
  }
  auto tables = matrix_curves(profile);
  if (!tables) {
    tone.note =
        "The embedded colour profile has no usable curves; the samples are taken as linear.";
    return tone;
  }
  tone.linear = is_straight((*tables)[0]) && is_straight((*tables)[1]) && is_straight((*tables)[2]);
  if (tone.linear) {
    tone.note = "The embedded colour profile is linear.";
    return tone;
  }
  (*tables)[3] = ToneCurves::linear().table(3);
  tone.curves = ToneCurves(std::move(*tables));
  tone.note =
      "The curves of the embedded colour profile are undone for red, green and blue; infrared is "
      "taken as linear.";
  return tone;
}

}  // namespace reseau
