// The choices of a recipe: light, dyes, areas, adaptation, space.
#include <cmath>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/color/element_color.h"

namespace reseau {
namespace {

ColorRecipe recipe(const char* set = "cornwell-clyne-1951") {
  ColorRecipe out;
  out.primaries = find_primary_set(set);
  out.space = OutputSpace::kXyz;
  return out;
}

TEST(Recipe, TheDefaultIsTheShortForm) {
  const ColorModel model = make_color_model(recipe());
  const ColorModel shorter =
      make_color_model("cornwell-clyne-1951", Balance::kNeutral, OutputSpace::kXyz);
  EXPECT_EQ(model.output_from_process, shorter.output_from_process);
}

// Under any light and adaptation the neutral réseau is the white of every space.
TEST(Recipe, ClearFilmIsWhiteUnderEveryLight) {
  for (const char* light : {"A", "C", "D50", "D65", "E", "4000K", "25000K", "planck:1800"}) {
    for (const AdaptationMethod method : {AdaptationMethod::kBradford, AdaptationMethod::kCat16}) {
      for (const SummationStep step : {SummationStep::k5nm, SummationStep::k1nm}) {
        ColorRecipe r = recipe();
        r.viewing.light = parse_light(light);
        r.viewing.adaptation = method;
        r.viewing.step = step;
        for (const std::string& space : output_space_words()) {
          if (space == "xyz") continue;
          r.space = parse_output_space(space);
          const Vector3 clear = multiply(make_color_model(r).output_from_process, Vector3{1, 1, 1});
          for (const double v : clear) EXPECT_NEAR(v, 1, 1e-12) << light << " " << space;
        }
      }
    }
  }
}

// 1 nm sums move a colour by less than anything else does, and by something.
TEST(Recipe, OneNanometreChangesLittle) {
  ColorRecipe r = recipe();
  const Matrix3 coarse = make_color_model(r).xyz_from_process;
  r.viewing.step = SummationStep::k1nm;
  const Matrix3 fine = make_color_model(r).xyz_from_process;
  EXPECT_NE(coarse, fine);
  for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(coarse[i], fine[i], 3e-3);
}

TEST(Recipe, ReadersOfAnySpaceGetTheSameColors) {
  const Vector3 pixel{0.7, 0.2, 0.4};
  for (const Balance balance :
       {Balance::kBrightness, Balance::kNeutral, Balance::kBradford, Balance::kNone}) {
    ColorRecipe r = recipe("harrison-horner-1939");
    r.balance = balance;
    const Xyz meant = multiply(make_color_model(r).xyz_from_process, pixel);
    for (const std::string& space : output_space_words()) {
      r.space = parse_output_space(space);
      const ColorModel model = make_color_model(r);
      const Xyz seen =
          multiply(multiply(xyz_d65_from_file(model.chromaticities, model.adopted_neutral),
                            model.output_from_process),
                   pixel);
      const double exposure = space == "process" ? model.reseau[1] : 1;
      for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(seen[i] * exposure, meant[i], 1e-12) << space;
    }
  }
}

TEST(Recipe, WhitesOfTheSpaces) {
  const auto white = [](const char* space) {
    ColorRecipe r = recipe();
    r.space = parse_output_space(space);
    return make_color_model(r).adopted_neutral;
  };
  EXPECT_EQ(white("prophoto"), (Chromaticity{0.3457, 0.3585}));
  EXPECT_EQ(white("aces-ap0"), (Chromaticity{0.32168, 0.33767}));
  EXPECT_EQ(white("display-p3"), (Chromaticity{0.3127, 0.3290}));
  EXPECT_EQ(white("rec2020"), (Chromaticity{0.3127, 0.3290}));
  EXPECT_EQ(white("film"), chromaticity_of(white_of(Illuminant::kD65)));
}

// SMPTE ST 2065-1 and ISO 22028-2 print the matrices to XYZ under their own white.
TEST(Recipe, PublishedMatricesOfTheSpaces) {
  const Matrix3 aces{0.9525523959, 0, 0.0000936786, 0.3439664498, 0.7281660966, -0.0721325464, 0, 0,
                     1.0088251844};
  const Matrix3 prophoto{0.7977, 0.1352, 0.0313, 0.2880, 0.7119, 0.0001, 0, 0, 0.8249};
  const Matrix3 own_aces = xyz_from_rgb(rgb_space_chromaticities("aces-ap0"));
  const Matrix3 own_prophoto = xyz_from_rgb(rgb_space_chromaticities("prophoto"));
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_NEAR(own_aces[i], aces[i], 2e-6);
    EXPECT_NEAR(own_prophoto[i], prophoto[i], 3e-4);
  }
}

TEST(Recipe, FilmIsTheProcessUpToFactors) {
  ColorRecipe r = recipe();
  r.balance = Balance::kBrightness;
  r.space = OutputSpace::kFilm;
  const ColorModel film = make_color_model(r);
  for (const std::size_t i : {1U, 2U, 3U, 5U, 6U, 7U}) {
    EXPECT_NEAR(film.output_from_process[i], 0, 1e-12);
  }
}

// Beer and Lambert: twice the dye squares the transmittance, no dye is clear.
TEST(Recipe, DyesFollowBeerAndLambert) {
  const PrimarySet& set = find_primary_set("cornwell-clyne-1951");
  const WavelengthGrid grid = observer_5nm().grid;
  const Spectrum printed = element_transmittance(set, 1, grid, {});
  const Spectrum twice = element_transmittance(set, 1, grid, {{1, 2, 1}, {0, 0, 0}});
  const Spectrum faded = element_transmittance(set, 1, grid, {{1, 2, 1}, {0, 0.5, 0}});
  const Spectrum gone = element_transmittance(set, 1, grid, {{1, 1, 1}, {0, 1, 0}});
  for (std::size_t i = 0; i < printed.values.size(); ++i) {
    EXPECT_NEAR(twice.values[i], printed.values[i] * printed.values[i], 1e-15);
    EXPECT_NEAR(faded.values[i], printed.values[i], 1e-15);
    EXPECT_EQ(gone.values[i], 1);
  }
  ColorRecipe r = recipe();
  r.viewing.dyes.fading = {0.3, 0.3, 0.3};
  EXPECT_GT(make_color_model(r).condition, make_color_model(recipe()).condition);
  r.viewing.dyes.fading = {1, 1, 1};
  EXPECT_THROW((void)make_color_model(r), InputError);  // three clear elements make no colours
  r.viewing.dyes.fading = {0, 1.1, 0};
  EXPECT_THROW((void)make_color_model(r), InputError);
  r.viewing.dyes = {{1, std::nan(""), 1}, {0, 0, 0}};
  EXPECT_THROW((void)make_color_model(r), InputError);
  ColorRecipe colors = recipe("hubicka-2025");
  colors.viewing.dyes.density = {1, 1, 2};
  EXPECT_THROW((void)make_color_model(colors), InputError);
}

TEST(Recipe, AreasAreReadByNameOrNumber) {
  EXPECT_EQ(parse_areas("dufaycolor").share, dufaycolor_areas());
  EXPECT_NEAR(parse_areas("1,2,1").share[1], 0.5, 1e-15);
  EXPECT_NEAR(parse_areas("finlay").share[2], 1.0 / 3, 1e-15);
  for (const char* word : {"", "1,2", "1,2,3,4", "0,1,1", "-1,1,1", "nan,1,1", "a,b,c", "1;2;3",
                           "1e308,1e308,1e308"}) {
    EXPECT_THROW((void)parse_areas(word), InputError) << word;
  }
  ColorRecipe r = recipe();
  r.balance = Balance::kBrightness;
  const Matrix3 micrograph = make_color_model(r).xyz_from_process;
  r.areas = parse_areas("dufaycolor-gawain");
  EXPECT_NE(make_color_model(r).xyz_from_process, micrograph);
}

TEST(Recipe, AWhiteBalanceScalesTheElements) {
  ColorRecipe r = recipe();
  const Matrix3 plain = make_color_model(r).output_from_process;
  r.white_balance = {1.1, 1, 0.9};
  const Matrix3 scaled = make_color_model(r).output_from_process;
  EXPECT_DOUBLE_EQ(scaled[0], 1.1 * plain[0]);
  EXPECT_DOUBLE_EQ(scaled[8], 0.9 * plain[8]);
  r.white_balance = {0, 1, 1};
  EXPECT_THROW((void)make_color_model(r), InputError);
}

// Every set that is built in makes colours, or says why not.
TEST(Recipe, EveryBuiltInSetCanBeUsed) {
  for (const PrimarySet& set : primary_sets()) {
    ColorRecipe r;
    r.primaries = set;
    r.balance = Balance::kBrightness;
    EXPECT_LT(make_color_model(r).condition, 100) << set.name;
  }
}

// Soft compression keeps luminance and order, and leaves unsaturated colours alone.
TEST(Gamut, CompressionKeepsWhatIsInsideAndOrdersWhatIsOutside) {
  const Rgb inside{0.5, 0.45, 0.4};
  EXPECT_EQ(compress_into_gamut(inside), inside);
  double last = 1;
  for (const double excess : {0.0, 0.1, 0.3, 1.0, 10.0}) {
    const Rgb out = compress_into_gamut({0.2, 0.5 + excess / 20, -excess});
    EXPECT_TRUE(in_gamut(out));
    EXPECT_LE(out[2], last);
    EXPECT_NEAR(srgb_luminance(out),
                std::clamp(srgb_luminance({0.2, 0.5 + excess / 20, -excess}), 0.0, 1.0), 1e-12);
    last = out[2];
  }
  EXPECT_TRUE(in_gamut(compress_into_gamut({7, 3, -2})));
  EXPECT_TRUE(in_gamut(compress_into_gamut({-1, -1, -1})));
}

}  // namespace
}  // namespace reseau
