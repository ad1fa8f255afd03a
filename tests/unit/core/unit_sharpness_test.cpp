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

// Sharpest in the middle, on the average over the frame what the curve says.
TEST(UnitSharpness, ChangesOverTheFrameThatWasCalibratedAndNoOther) {
  const UnitBlur blur{0.8, 0.02, 0.05};
  const UnitField field{{9, 0.1, 0, 0.3, 0, 0.3}, std::vector<double>(36, 0.0), {1400, 1000}};
  const auto surface = unit_surface(blur, field, {1410, 1000});
  ASSERT_TRUE(surface);
  double mean = 0;
  constexpr int kSteps = 100;
  for (int j = 0; j < kSteps; ++j) {
    for (int i = 0; i < kSteps; ++i) {
      const double s = surface->sigma_px({(i + 0.5) / kSteps * 1410, (j + 0.5) / kSteps * 1000});
      mean += s * s / (kSteps * kSteps);
    }
  }
  EXPECT_NEAR(mean, 0.64, 1e-4);
  EXPECT_NEAR(
      std::pow(surface->sigma_px({1410, 1000}), 2) - std::pow(surface->sigma_px({705, 500}), 2),
      0.7, 1e-9);
  EXPECT_FALSE(unit_surface(blur, field, {1400, 1500}));
}

}  // namespace
}  // namespace reseau
