#include "capture/image/icc.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include <lcms2.h>

#include "core/base/check.h"

namespace reseau {
namespace {

struct CloseProfile {
  void operator()(void* profile) const { cmsCloseProfile(profile); }
};
using Profile = std::unique_ptr<void, CloseProfile>;

struct FreeCurve {
  void operator()(cmsToneCurve* curve) const { cmsFreeToneCurve(curve); }
};
using Curve = std::unique_ptr<cmsToneCurve, FreeCurve>;

struct FreeTransform {
  void operator()(void* transform) const { cmsDeleteTransform(transform); }
};
using Transform = std::unique_ptr<void, FreeTransform>;

constexpr std::size_t kEntries = 65536;
using Tables = std::array<std::vector<float>, 4>;

std::vector<std::byte> saved(const Profile& profile) {
  cmsUInt32Number size = 0;
  CHECK(cmsSaveProfileToMem(profile.get(), nullptr, &size));
  std::vector<std::byte> out(size);
  CHECK(cmsSaveProfileToMem(profile.get(), out.data(), &size));
  return out;
}

// lcms2 puts the time of creation into bytes 24-35 of the header (ICC.1, header fields): replaced
// by a constant, six big-endian 16-bit numbers, and the profile ID (MD5) is computed after that.
std::vector<std::byte> reproducible(const Profile& profile) {
  constexpr std::array<std::uint8_t, 12> kDate = {0x07, 0xEA, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0};
  auto bytes = saved(profile);
  CHECK(bytes.size() > 128);
  for (std::size_t i = 0; i < kDate.size(); ++i) bytes[24 + i] = std::byte{kDate[i]};
  const Profile dated(
      cmsOpenProfileFromMem(bytes.data(), static_cast<cmsUInt32Number>(bytes.size())));
  CHECK(dated != nullptr && cmsMD5computeID(dated.get()));
  return saved(dated);
}

void describe(const Profile& profile, const wchar_t* text) {
  cmsMLU* mlu = cmsMLUalloc(nullptr, 1);
  CHECK(mlu != nullptr && cmsMLUsetWide(mlu, "en", "US", text) &&
        cmsWriteTag(profile.get(), cmsSigProfileDescriptionTag, mlu));
  cmsMLUfree(mlu);
}

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

std::optional<Tables> matrix_curves(const Profile& profile) {
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

std::optional<Tables> neutral_axis(const Profile& profile) {
  const Profile xyz(cmsCreateXYZProfile());
  const Transform transform(cmsCreateTransform(profile.get(), TYPE_RGB_DBL, xyz.get(), TYPE_XYZ_DBL,
                                               INTENT_RELATIVE_COLORIMETRIC,
                                               cmsFLAGS_NOCACHE | cmsFLAGS_NOOPTIMIZE));
  if (transform == nullptr) return std::nullopt;
  std::vector<double> luminance(kEntries);
  for (std::size_t i = 0; i < kEntries; ++i) {
    const double v = static_cast<double>(i) / 65535.0;
    const std::array<double, 3> rgb = {v, v, v};
    std::array<double, 3> out{};
    cmsDoTransform(transform.get(), rgb.data(), out.data(), 1);
    luminance[i] = out[1];
  }
  const double white = luminance.back();
  if (!(white > 1e-3) || !std::isfinite(white)) return std::nullopt;
  std::vector<float> table(kEntries);
  for (std::size_t i = 0; i < kEntries; ++i) table[i] = static_cast<float>(luminance[i] / white);
  if (!all_finite(table)) return std::nullopt;
  return Tables{table, table, table, {}};
}

}  // namespace

std::vector<std::byte> linear_scanner_icc() {
  const cmsCIExyY white = {0.3127, 0.3290, 1.0};
  const cmsCIExyYTRIPLE primaries = {{0.64, 0.33, 1.0}, {0.30, 0.60, 1.0}, {0.15, 0.06, 1.0}};
  const Curve straight(cmsBuildGamma(nullptr, 1.0));
  CHECK(straight != nullptr);
  cmsToneCurve* curves[3] = {straight.get(), straight.get(), straight.get()};
  const Profile profile(cmsCreateRGBProfile(&white, &primaries, curves));
  CHECK(profile != nullptr);
  describe(profile, L"reseau linear scanner RGB (primaries not measured)");
  return reproducible(profile);
}

std::vector<std::byte> srgb_icc() {
  const Profile profile(cmsCreate_sRGBProfile());
  CHECK(profile != nullptr);
  return reproducible(profile);
}

IccTone tone_of_icc(std::span<const std::byte> icc) {
  IccTone tone;
  const Profile profile(
      cmsOpenProfileFromMem(icc.data(), static_cast<cmsUInt32Number>(icc.size())));
  if (profile == nullptr) {
    tone.note = "The embedded colour profile is damaged; the samples are taken as linear.";
    return tone;
  }
  if (cmsGetColorSpace(profile.get()) != cmsSigRgbData) {
    tone.note = "The embedded colour profile is not one of RGB; the samples are taken as linear.";
    return tone;
  }
  const bool matrix = cmsIsMatrixShaper(profile.get());
  auto tables = matrix ? matrix_curves(profile) : neutral_axis(profile);
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
  tone.note = matrix ? "The curves of the embedded colour profile are undone for red, green and "
                       "blue; infrared is taken as linear."
                     : "The embedded colour profile is a table: the luminance of its neutral axis "
                       "is undone, the same for red, green and blue; infrared is taken as linear.";
  return tone;
}

}  // namespace reseau
