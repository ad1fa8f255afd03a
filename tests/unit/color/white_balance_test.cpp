#include "core/color/white_balance.h"

#include <limits>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/color/element_color.h"

namespace reseau {
namespace {

TEST(WhiteBalance, MakesTheMeanNeutralAndKeepsItsLuminance) {
  for (const Balance balance : {Balance::kNeutral, Balance::kBrightness, Balance::kNone}) {
    ColorRecipe recipe;
    recipe.balance = balance;
    recipe.space = OutputSpace::kXyz;
    const Matrix3 xyz = make_color_model(recipe).xyz_from_process;
    const Vector3 mean{0.31, 0.12, 0.22};
    recipe.white_balance = neutral_white_balance(mean, xyz);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(recipe.white_balance[i] * mean[i], recipe.white_balance[0] * mean[0], 1e-15);
    }
    const Xyz before = multiply(xyz, mean);
    const Xyz after = multiply(make_color_model(recipe).output_from_process, mean);
    EXPECT_NEAR(after[1], before[1], 1e-12);
    if (balance != Balance::kNeutral) continue;
    const Xyz d65 = white_of(Illuminant::kD65);
    EXPECT_NEAR(after[0] / after[1], d65[0], 1e-9);
    EXPECT_NEAR(after[2] / after[1], d65[2], 1e-9);
  }
}

TEST(WhiteBalance, RefusesAnAreaWithoutLight) {
  const Matrix3 xyz = make_color_model(ColorRecipe{}).xyz_from_process;
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (const Vector3& mean : {Vector3{0, 0.1, 0.1}, Vector3{-0.1, 0.1, 0.1}, Vector3{0, 0, 0},
                              Vector3{kNan, 0.1, 0.1}, Vector3{1, 1e-5, 1}}) {
    EXPECT_THROW((void)neutral_white_balance(mean, xyz), InputError);
  }
}

}  // namespace
}  // namespace reseau
