#include "core/reconstruct/blurred_cell.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace reseau {
namespace {

TEST(ScreenPattern, AreasAreThoseOfTheMicrograph) {
  const ScreenPattern& pattern = ScreenPattern::dufaycolor();
  EXPECT_NEAR(pattern.area(0), 0.4208, 1e-4);
  EXPECT_NEAR(pattern.area(1), 0.2651, 1e-4);
  EXPECT_NEAR(pattern.area(2), 0.3141, 1e-4);
}

TEST(BlurredCell, SharesSumToOneAndAreSharpInTheMiddleOfElements) {
  const BlurredCell cell(ScreenPattern::dufaycolor(), {1 / 16.0, 0, 0, 1 / 16.0}, 0.3);
  for (float v = -1; v < 1; v += 0.11F) {
    for (float u = -1; u < 1; u += 0.13F) {
      const auto m = cell.shares(u, v);
      EXPECT_NEAR(m[0] + m[1] + m[2], 1, 1e-5);
    }
  }
  EXPECT_GT(cell.shares(0.2F, 0.5F)[0], 0.98F);
  EXPECT_GT(cell.shares(0, 0)[1], 0.98F);
  EXPECT_GT(cell.shares(0.5F, 0)[2], 0.98F);
}

// A red line alone under a Gaussian is a difference of two error functions, repeated.
TEST(BlurredCell, BlurOfALineMatchesTheErrorFunction) {
  const double period = 8, sigma = 1.1;
  const BlurredCell cell(ScreenPattern::dufaycolor(), {1 / period, 0, 0, 1 / period}, sigma);
  const double half = kDufaycolorRedWidth / 2 * period;
  for (double v = 0; v < 1; v += 0.07) {
    double expected = 0;
    for (int k = -3; k <= 3; ++k) {
      const double x = (v - 0.5 - k) * period;
      const double scale = sigma * std::numbers::sqrt2;
      expected += 0.5 * (std::erf((x + half) / scale) - std::erf((x - half) / scale));
    }
    EXPECT_NEAR(static_cast<double>(cell.shares(0.37F, static_cast<float>(v))[0]), expected, 1e-3)
        << v;
  }
}

TEST(BlurredCell, CrosstalkGrowsWithBlur) {
  const Mat2 map{1 / 7.8, 0, 0, 1 / 7.8};
  const BlurredCell sharp(ScreenPattern::dufaycolor(), map, 0.4),
      soft(ScreenPattern::dufaycolor(), map, 1.5);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_GT(sharp.mean_crosstalk()[k][k], soft.mean_crosstalk()[k][k]);
    EXPECT_NEAR(
        soft.mean_crosstalk()[k][0] + soft.mean_crosstalk()[k][1] + soft.mean_crosstalk()[k][2], 1,
        1e-6);
  }
}

}  // namespace
}  // namespace reseau
