// The profiles of the spaces, read by lcms2 as any program would.
#include "capture/image/space_icc.h"

#include <cmath>
#include <ctime>

#include <gtest/gtest.h>
#include <lcms2.h>

#include "capture/image/icc.h"
#include "capture/image/lcms_handles.h"
#include "core/base/error.h"
#include "core/color/adaptation.h"

namespace reseau {
namespace {

LcmsProfile opened(const std::vector<std::byte>& icc) {
  return LcmsProfile(cmsOpenProfileFromMem(icc.data(), static_cast<cmsUInt32Number>(icc.size())));
}

LcmsTransform to_xyz(const std::vector<std::byte>& icc) {
  const LcmsProfile from = opened(icc), xyz(cmsCreateXYZProfile());
  return LcmsTransform(cmsCreateTransform(from.get(), TYPE_RGB_DBL, xyz.get(), TYPE_XYZ_DBL,
                                          INTENT_RELATIVE_COLORIMETRIC,
                                          cmsFLAGS_NOCACHE | cmsFLAGS_NOOPTIMIZE));
}

Xyz transformed(const LcmsTransform& transform, const Vector3& rgb) {
  Xyz xyz{};
  cmsDoTransform(transform.get(), rgb.data(), xyz.data(), 1);
  return xyz;
}

Matrix3 pcs_from_d65() {
  return bradford_target_from_source(white_of(Illuminant::kD65), {0.9642, 1, 0.8249});
}

std::vector<ColorRecipe> recipes() {
  std::vector<ColorRecipe> all;
  for (const std::string& word : output_space_words()) {
    for (const Balance balance : {Balance::kNeutral, Balance::kBrightness}) {
      ColorRecipe recipe;
      recipe.space = parse_output_space(word);
      recipe.balance = balance;
      recipe.white_balance = {1.1, 1, 0.9};  // belongs to the picture, not to its profile
      all.push_back(recipe);
    }
  }
  return all;
}

TEST(SpaceIcc, LcmsReadsTheColoursThatWeMean) {
  const Vector3 colors[] = {{1, 1, 1}, {0.18, 0.18, 0.18}, {1, 0, 0},       {0, 1, 0},
                            {0, 0, 1}, {0.7, 0.2, 0.05},   {0.02, 0.5, 0.9}};
  for (const ColorRecipe& recipe : recipes()) {
    ColorRecipe plain = recipe;
    plain.white_balance = {1, 1, 1};
    const ColorModel model = make_color_model(plain);
    const Matrix3 pcs_from_output = multiply(
        pcs_from_d65(), multiply(model.xyz_from_process, inverse(model.output_from_process)));
    const auto transform = to_xyz(picture_icc(recipe, {}));
    ASSERT_NE(transform, nullptr) << space_word(recipe.space);
    for (const Vector3& color : colors) {
      const Xyz theirs = transformed(transform, color), ours = multiply(pcs_from_output, color);
      for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(theirs[i], ours[i], 6e-5) << space_word(recipe.space);
      }
    }
  }
}

TEST(SpaceIcc, WhiteIsTheWhiteOfTheConnectionSpaceToTheLastBit) {
  for (const char* word :
       {"srgb-linear", "display-p3", "rec2020", "prophoto", "aces-ap0", "film", "process"}) {
    ColorRecipe recipe;
    recipe.space = parse_output_space(word);
    const LcmsProfile profile = opened(picture_icc(recipe, {}));
    double x = 0, y = 0, z = 0;
    for (const auto tag : {cmsSigRedColorantTag, cmsSigGreenColorantTag, cmsSigBlueColorantTag}) {
      const auto* xyz = static_cast<const cmsCIEXYZ*>(cmsReadTag(profile.get(), tag));
      ASSERT_NE(xyz, nullptr);
      x += xyz->X;
      y += xyz->Y;
      z += xyz->Z;
    }
    EXPECT_DOUBLE_EQ(x * 65536, 0xF6D6) << word;
    EXPECT_DOUBLE_EQ(y * 65536, 0x10000) << word;
    EXPECT_DOUBLE_EQ(z * 65536, 0xD32D) << word;
  }
}

TEST(SpaceIcc, TheCastOfTheClearReseauStaysWithBalanceBrightness) {
  ColorRecipe recipe;
  recipe.space = OutputSpace::kProcess;
  recipe.balance = Balance::kBrightness;
  const Xyz white = transformed(to_xyz(picture_icc(recipe, {})), {1, 1, 1});
  EXPECT_NEAR(white[1], multiply(pcs_from_d65(), make_color_model(recipe).reseau)[1], 5e-5);
  EXPECT_GT(std::abs(white[0] / white[1] - 0.9642), 0.05);
}

TEST(SpaceIcc, SrgbIsThatOfLcms) {
  const auto ours = to_xyz(picture_icc(ColorRecipe{}, parse_icc_encoding("srgb")));
  const auto theirs = to_xyz(srgb_icc());
  for (double v = 0; v <= 1; v += 1.0 / 64) {
    const Xyz a = transformed(ours, {v, v * v, 1 - v}), b = transformed(theirs, {v, v * v, 1 - v});
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], 1.5e-4);
  }
}

TEST(SpaceIcc, GammaIsApplied) {
  ColorRecipe recipe;
  recipe.space = OutputSpace::kProPhoto;
  const auto transform = to_xyz(picture_icc(recipe, parse_icc_encoding("1.8")));
  EXPECT_NEAR(transformed(transform, {0.5, 0.5, 0.5})[1], std::pow(0.5, 1.8), 2e-5);
  for (const char* word : {"", "2.2x", "0", "-1", "nan", "cubic"}) {
    EXPECT_THROW((void)parse_icc_encoding(word), InputError) << word;
  }
}

TEST(SpaceIcc, SameBytesWhenever) {
  for (const ColorRecipe& recipe : recipes()) {
    const auto icc = picture_icc(recipe, {});
    ::setenv("TZ", "Pacific/Auckland", 1);
    ::tzset();
    EXPECT_EQ(icc, picture_icc(recipe, {}));
    ::unsetenv("TZ");
    ::tzset();
    const LcmsProfile profile = opened(icc);
    ASSERT_NE(profile, nullptr);
    EXPECT_NEAR(cmsGetProfileVersion(profile.get()), 4.3, 0.01);
    EXPECT_EQ(cmsGetDeviceClass(profile.get()), cmsSigDisplayClass);
    tm date{};
    cmsGetHeaderCreationDateTime(profile.get(), &date);
    EXPECT_EQ(date.tm_year, 126);
  }
}

TEST(SpaceIcc, RefusesWhatNoProfileCanHold) {
  EXPECT_THROW((void)matrix_icc({1, 1, 0, 1, 1, 0, 1, 1, 1}, {}, "flat"), InputError);
  EXPECT_THROW((void)matrix_icc({std::nan(""), 0, 0, 0, 1, 0, 0, 0, 1}, {}, "nan"), InputError);
  EXPECT_THROW((void)matrix_icc({1e9, 0, 0, 0, 1, 0, 0, 0, 1}, {}, "far"), InputError);
}

}  // namespace
}  // namespace reseau
