// Every set of primaries with every balance, space and adaptation: the white, the way back, what a
// reader of the files sees, and lcms2 as an independent witness of matrices and profiles.
#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include "capture/color/color_record.h"
#include "capture/image/exr_file.h"
#include "capture/image/lcms_handles.h"
#include "capture/image/space_icc.h"
#include "core/color/adaptation.h"
#include "tests/support/temp_dir.h"

namespace reseau {
namespace {

constexpr std::array kBalances{Balance::kNone, Balance::kBrightness, Balance::kNeutral,
                               Balance::kBradford};
constexpr std::array kAdaptations{AdaptationMethod::kBradford, AdaptationMethod::kCat16};

// The standards' own figures, not those of our tables.
const std::map<std::string, std::array<double, 8>> kStandards{
    {"srgb-linear", {0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290}},
    {"display-p3", {0.680, 0.320, 0.265, 0.690, 0.150, 0.060, 0.3127, 0.3290}},
    {"rec2020", {0.708, 0.292, 0.170, 0.797, 0.131, 0.046, 0.3127, 0.3290}},
    {"prophoto", {0.7347, 0.2653, 0.1596, 0.8404, 0.0366, 0.0001, 0.3457, 0.3585}},
    {"aces-ap0", {0.7347, 0.2653, 0, 1, 0.0001, -0.0770, 0.32168, 0.33767}},
};

ColorRecipe recipe_of(const PrimarySet& set, Balance balance, const std::string& space,
                      AdaptationMethod adaptation) {
  ColorRecipe recipe;
  recipe.primaries = set;
  recipe.balance = balance;
  recipe.space = parse_output_space(space);
  recipe.viewing.light = parse_light("A");  // far from D65: an adaptation has something to do
  recipe.viewing.adaptation = adaptation;
  return recipe;
}

template <typename Check>
void for_each_recipe(const Check& check) {
  for (const PrimarySet& set : primary_sets()) {
    for (const Balance balance : kBalances) {
      for (const AdaptationMethod adaptation : kAdaptations) {
        for (const std::string& space : output_space_words()) {
          SCOPED_TRACE(set.name + " " + balance_word(balance) + " " + space + " " +
                       (adaptation == AdaptationMethod::kCat16 ? "cat16" : "bradford"));
          check(recipe_of(set, balance, space, adaptation), space);
        }
      }
    }
  }
}

void expect_near(const Matrix3& a, const Matrix3& b, double within) {
  for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(a[i], b[i], within) << i;
}

TEST(ColorSweep, WhiteIsWhereItIsSaidToBeAndEveryStepCanBeUndone) {
  const Xyz d65 = white_of(Illuminant::kD65);
  for_each_recipe([&](const ColorRecipe& recipe, const std::string& space) {
    const ColorModel model = make_color_model(recipe);
    EXPECT_LT(model.condition, 200);
    // Products of matrices, whose errors grow with the condition.
    expect_near(multiply(inverse(model.output_from_process), model.output_from_process), kIdentity3,
                1e-12 * model.condition);
    const Vector3 clear = multiply(model.output_from_process, Vector3{1, 1, 1});
    const bool white = recipe.balance == Balance::kNeutral || recipe.balance == Balance::kBradford;
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_TRUE(std::isfinite(clear[i]) && std::isfinite(model.chromaticities.xy[i][0]) &&
                  std::isfinite(model.chromaticities.xy[i][1]));
      if (white) {
        EXPECT_NEAR(model.reseau[i], d65[i], 1e-12);
        EXPECT_NEAR(clear[i], space == "xyz" ? d65[i] : 1, 1e-11);
      }
    }
    if (recipe.balance != Balance::kBrightness) return;
    ColorRecipe under_d65 = recipe;  // adapted to D65 afterwards, Y is not exactly 1 any more
    under_d65.viewing.light = light_of(Illuminant::kD65);
    EXPECT_NEAR(make_color_model(under_d65).reseau[1], 1, 1e-14);
  });
}

TEST(ColorSweep, AReaderSeesTheColoursThatAreMeant) {
  for_each_recipe([](const ColorRecipe& recipe, const std::string& space) {
    const ColorModel model = make_color_model(recipe);
    // Only `process` has no place for the exposure: its (1, 1, 1) has Y = 1 for a reader.
    const double exposure = recipe.space == OutputSpace::kProcess ? model.reseau[1] : 1;
    Matrix3 seen = multiply(xyz_d65_from_file(model.chromaticities, model.adopted_neutral),
                            model.output_from_process);
    for (double& v : seen) v *= exposure;
    expect_near(seen, model.xyz_from_process, 1e-11);
    const auto standard = kStandards.find(space);
    if (standard == kStandards.end()) return;
    for (std::size_t i = 0; i < 8; ++i) {
      EXPECT_EQ(model.chromaticities.xy[i / 2][i % 2], standard->second[i]);
    }
  });
}

TEST(ColorSweep, FilesSayTheChromaticitiesOfTheirSpace) {
  const test::TempDir dir;
  const PrimarySet& set = find_primary_set("collins-giles-1952");
  for (const std::string& space : output_space_words()) {
    const ColorRecipe recipe =
        recipe_of(set, Balance::kBrightness, space, AdaptationMethod::kBradford);
    const ColorModel model = make_color_model(recipe);
    ExrOptions options;
    declare_color(recipe, options);
    const auto path = dir / (space + ".exr");
    FloatImageWriter writer(path, 1, 1, {"R", "G", "B"}, options);
    writer.rows(0, 1, std::array{-0.5F, 2.0F, 1e-20F});
    writer.finish();
    const ExrReader reader(path);
    for (std::size_t i = 0; i < 8; ++i) {
      EXPECT_FLOAT_EQ(static_cast<float>(reader.chromaticities().value().xy[i / 2][i % 2]),
                      static_cast<float>(model.chromaticities.xy[i / 2][i % 2]))
          << space;
    }
    EXPECT_NEAR(reader.adopted_neutral().value()[0], model.adopted_neutral[0], 1e-7) << space;
    expect_near(output_from_process_of(reader, space), model.output_from_process, 0);
    // No handling of the gamut here: what lies outside is kept to the bit.
    EXPECT_EQ(read_exr(path).samples, (std::vector<float>{-0.5F, 2.0F, 1e-20F})) << space;
  }
}

LcmsTransform pcs_from(const LcmsProfile& profile) {
  const LcmsProfile xyz(cmsCreateXYZProfile());
  return LcmsTransform(cmsCreateTransform(profile.get(), TYPE_RGB_DBL, xyz.get(), TYPE_XYZ_DBL,
                                          INTENT_RELATIVE_COLORIMETRIC,
                                          cmsFLAGS_NOCACHE | cmsFLAGS_NOOPTIMIZE));
}

// Columns: what lcms2 makes of full red, green and blue, in the connection space (D50).
Matrix3 matrix_of(const LcmsTransform& transform) {
  const auto of = [&](const Vector3& rgb) {
    Xyz xyz{};
    cmsDoTransform(transform.get(), rgb.data(), xyz.data(), 1);
    return xyz;
  };
  return from_columns(of({1, 0, 0}), of({0, 1, 0}), of({0, 0, 1}));
}

Matrix3 pcs_from_d65() {
  return bradford_target_from_source(white_of(Illuminant::kD65), {0.9642, 1, 0.8249});
}

TEST(ColorSweep, ProfilesAreReadAsMeantAndHaveTheSameBytesTwice) {
  std::map<std::string, std::vector<std::byte>> of_standard;
  for_each_recipe([&](const ColorRecipe& recipe, const std::string& space) {
    const std::vector<std::byte> icc = picture_icc(recipe, {});
    // That of a standard space is the same whatever the film was; it is looked at once.
    const bool film = space == "process" || space == "film";
    if (!film) {
      const auto [first, is_new] = of_standard.emplace(space, icc);
      EXPECT_EQ(first->second, icc);
      if (!is_new) return;
    }
    EXPECT_EQ(icc, picture_icc(recipe, {}));
    const LcmsProfile profile(
        cmsOpenProfileFromMem(icc.data(), static_cast<cmsUInt32Number>(icc.size())));
    ASSERT_NE(profile, nullptr);
    const ColorModel model = make_color_model(recipe);
    const Matrix3 meant = multiply(
        pcs_from_d65(), multiply(model.xyz_from_process, inverse(model.output_from_process)));
    expect_near(matrix_of(pcs_from(profile)), meant, 5e-5);  // steps of 1/65536, thrice
  });
}

// lcms2 makes the spaces from the same chromaticities by itself.
TEST(ColorSweep, LcmsMakesTheSameMatricesOfTheSpaces) {
  const LcmsCurve straight(cmsBuildGamma(nullptr, 1));
  cmsToneCurve* curves[] = {straight.get(), straight.get(), straight.get()};
  const auto by_lcms = [&](const Chromaticities& space) {
    const auto& xy = space.xy;
    const cmsCIExyY white = {xy[3][0], xy[3][1], 1};
    const cmsCIExyYTRIPLE primaries = {
        {xy[0][0], xy[0][1], 1}, {xy[1][0], xy[1][1], 1}, {xy[2][0], xy[2][1], 1}};
    return matrix_of(pcs_from(LcmsProfile(cmsCreateRGBProfile(&white, &primaries, curves))));
  };
  for (const auto& [space, standard] : kStandards) {
    SCOPED_TRACE(space);
    const Chromaticities known = rgb_space_chromaticities(space);
    expect_near(multiply(pcs_from_d65(), inverse(rgb_from_xyz_d65(known))), by_lcms(known), 5e-5);
  }
  // A profile of the film's elements about D65 is the balance `neutral`.
  for (const PrimarySet& set : primary_sets()) {
    SCOPED_TRACE(set.name);
    ColorRecipe recipe;
    recipe.primaries = set;
    recipe.space = OutputSpace::kFilm;
    const ColorModel model = make_color_model(recipe);
    expect_near(multiply(pcs_from_d65(), model.xyz_from_process), by_lcms(model.chromaticities),
                5e-5);
  }
}

}  // namespace
}  // namespace reseau
