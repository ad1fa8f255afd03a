#include "core/color/balance.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/color/primaries.h"

namespace reseau {
namespace {

Matrix3 weighted(const char* set) {
  return scale_columns(element_primaries(set, Illuminant::kD65), dufaycolor_areas());
}

const Xyz& white() {
  static const Xyz d65 = white_of(Illuminant::kD65);
  return d65;
}

TEST(Balance, WordsAreRead) {
  EXPECT_EQ(parse_balance("none"), Balance::kNone);
  EXPECT_EQ(parse_balance("brightness"), Balance::kBrightness);
  EXPECT_EQ(parse_balance("neutral"), Balance::kNeutral);
  EXPECT_EQ(parse_balance("bradford"), Balance::kBradford);
  EXPECT_THROW((void)parse_balance("grey"), InputError);
}

TEST(Balance, NoneLeavesTheMatrix) {
  EXPECT_EQ(apply_balance(weighted("neblette-1952"), Balance::kNone, white()),
            weighted("neblette-1952"));
}

TEST(Balance, BrightnessKeepsTheColorOfTheReseau) {
  const Matrix3 before = weighted("cornwell-clyne-1951");
  const Xyz after = reseau_color(apply_balance(before, Balance::kBrightness, white()));
  EXPECT_NEAR(after[1], 1.0, 1e-15);
  EXPECT_NEAR(chromaticity_of(after)[0], chromaticity_of(reseau_color(before))[0], 1e-15);
  EXPECT_NEAR(chromaticity_of(after)[0], 0.33596, 1e-4);
  EXPECT_NEAR(chromaticity_of(after)[1], 0.30325, 1e-4);
}

TEST(Balance, NeutralAndBradfordMakeTheReseauWhite) {
  for (const std::string& set : primary_set_names()) {
    for (const Balance balance : {Balance::kNeutral, Balance::kBradford}) {
      const Xyz clear = reseau_color(apply_balance(weighted(set.c_str()), balance, white()));
      for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(clear[i], white()[i], 1e-14) << set;
      }
    }
  }
}

TEST(Balance, NeutralKeepsTheChromaticityOfEachElement) {
  const Matrix3 before = weighted("harrison-horner-1939");
  const Matrix3 after = apply_balance(before, Balance::kNeutral, white());
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(chromaticity_of(column(after, i))[0], chromaticity_of(column(before, i))[0], 1e-15);
    EXPECT_NEAR(chromaticity_of(column(after, i))[1], chromaticity_of(column(before, i))[1], 1e-15);
  }
}

TEST(Balance, RefusesSingularPrimaries) {
  const Xyz red = xyz_from_chromaticity({0.6, 0.35}, 0.2);
  const Xyz blue = xyz_from_chromaticity({0.15, 0.08}, 0.1);
  const Matrix3 two_colors = from_columns(red, blue, blue);
  const Matrix3 nearly = from_columns(red, blue, {blue[0] + 1e-9, blue[1], blue[2]});
  Matrix3 not_a_number = weighted("srgb");
  not_a_number[2] = std::nan("");
  for (const Balance balance :
       {Balance::kNone, Balance::kBrightness, Balance::kNeutral, Balance::kBradford}) {
    EXPECT_THROW((void)apply_balance(two_colors, balance, white()), InputError);
    EXPECT_THROW((void)apply_balance(nearly, balance, white()), InputError);
    EXPECT_THROW((void)apply_balance(not_a_number, balance, white()), InputError);
    EXPECT_THROW((void)apply_balance(Matrix3{}, balance, white()), InputError);
  }
}

TEST(Balance, RefusesAWhiteThatThePrimariesCannotMake) {
  const Matrix3 all_reddish = from_columns(xyz_from_chromaticity({0.64, 0.33}, 0.2),
                                           xyz_from_chromaticity({0.50, 0.42}, 0.4),
                                           xyz_from_chromaticity({0.45, 0.30}, 0.1));
  EXPECT_THROW((void)apply_balance(all_reddish, Balance::kNeutral, white()), InputError);
  EXPECT_NO_THROW((void)apply_balance(all_reddish, Balance::kBrightness, white()));
}

}  // namespace
}  // namespace reseau
