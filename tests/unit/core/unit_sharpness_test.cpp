#include "core/reconstruct/unit_sharpness.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace reseau {
namespace {

constexpr double kPi = std::numbers::pi;
// A réseau of 7.8 px at 23 degrees.
const Mat2 kLinear{0.118, 0.050, -0.050, 0.118};

std::vector<TransferPoint> curve(double sigma_px, double far_share, double halo_px) {
  std::vector<TransferPoint> points;
  for (int i = 0; i <= 35; ++i) {
    const double f = 0.02 * i;
    const auto gaussian = [f](double s) { return std::exp(-2 * kPi * kPi * s * s * f * f); };
    points.push_back(
        {f, (1 - far_share) * gaussian(sigma_px) + far_share * gaussian(halo_px), 1e-3});
  }
  return points;
}

TEST(UnitBlur, TellsTheGaussianFromLightThatGoesFar) {
  const auto blur = unit_blur(curve(0.8, 0.07, 12), kLinear);
  ASSERT_TRUE(blur.has_value());
  EXPECT_NEAR(blur->sigma_px, 0.8, 1e-3);
  EXPECT_NEAR(blur->far_share, 0.07, 1e-3);
  EXPECT_GT(blur->sd_px, 0);
  EXPECT_LT(blur->sd_px, 0.05);
}

TEST(UnitBlur, LightThatStaysWithinAPeriodIsNotFar) {
  const auto blur = unit_blur(curve(0.6, 0.2, 1.1), kLinear);
  ASSERT_TRUE(blur.has_value());
  EXPECT_LT(blur->far_share, 0.03);
  EXPECT_GT(blur->sigma_px, 0.6);
}

TEST(UnitBlur, SaysNothingWhereTheCurveDoesNot) {
  EXPECT_FALSE(unit_blur({}, kLinear).has_value());
  std::vector<TransferPoint> low = curve(0.8, 0, 12);
  low.resize(6);  // ends at 0.1 cycles/px
  EXPECT_FALSE(unit_blur(low, kLinear).has_value());
  std::vector<TransferPoint> rising;
  for (int i = 0; i <= 35; ++i) rising.push_back({0.02 * i, 0.5 + 0.01 * i, 1e-3});
  EXPECT_FALSE(unit_blur(rising, kLinear).has_value());
  for (TransferPoint& p : rising) p.value = std::nan("");
  EXPECT_FALSE(unit_blur(rising, kLinear).has_value());
}

}  // namespace
}  // namespace reseau
