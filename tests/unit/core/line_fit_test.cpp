#include "core/screen/line_fit.h"

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace reseau {
namespace {

constexpr double kLines = 1000;

template <typename Error>
std::vector<LineSample> strips(double noise_px, Error error) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal(0, noise_px);
  std::vector<LineSample> samples;
  const double info = 1 / (noise_px * noise_px);
  for (double y = 3.5; y < kLines; y += 8) {
    for (double x = 64; x < 1000; x += 128) {
      const Vec2 e = error(x, y);
      samples.push_back({{x, y}, {e.x + normal(random), e.y + normal(random)}, info, info});
    }
  }
  return samples;
}

TEST(LineFit, NoiseAloneIsNoError) {
  const auto samples = strips(0.03, [](double, double) { return Vec2{}; });
  EXPECT_TRUE(fit_line_error(samples, LineError::Axis::kLines, 128, kLines, 8).error.none());
}

TEST(LineFit, FindsAWobbleOfSixtyLines) {
  const auto wobble = [](double, double y) {
    const double phase = 2 * std::numbers::pi * y / 60;
    return Vec2{0.1 * std::sin(phase), 0.6 * std::sin(phase)};
  };
  const LineFit fit = fit_line_error(strips(0.02, wobble), LineError::Axis::kLines, 128, kLines, 8);
  ASSERT_FALSE(fit.error.none());
  double sum = 0;
  int n = 0;
  for (double y = 4; y < kLines - 4; y += 3, ++n) {
    const Vec2 off = fit.error.at({500, y}) - wobble(0, y);
    sum += dot(off, off);
  }
  EXPECT_LT(std::sqrt(sum / n), 0.02);
}

TEST(LineFit, WhatChangesAcrossTheLineIsNoErrorOfTheLine) {
  const auto warp = [](double x, double y) {
    return Vec2{0, 0.3 * std::sin(x / 60) * std::sin(y / 30)};
  };
  EXPECT_TRUE(
      fit_line_error(strips(0.02, warp), LineError::Axis::kLines, 128, kLines, 8).error.none());
}

// A small scan has two strips of each kind; their middles are as far apart as they are long.
TEST(LineFit, FourStripsAreEnoughToBelieveAWobble) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal(0, 0.02);
  std::vector<LineSample> samples;
  for (double x = 7.5; x < 400; x += 16) {
    for (double y = 72; y < 552; y += 144) {
      const double e = 0.6 * std::sin(2 * std::numbers::pi * x / 220);
      samples.push_back({{x, y}, {e + normal(random), normal(random)}, 2500, 2500});
    }
  }
  const LineFit fit = fit_line_error(samples, LineError::Axis::kColumns, 144, 400, 16);
  ASSERT_FALSE(fit.error.none());
  EXPECT_NEAR(fit.error.at({55, 300}).x, 0.6, 0.05);
  EXPECT_NEAR(fit.error.at({165, 300}).x, -0.6, 0.05);
}

TEST(LineFit, AnEmptyListIsNoError) {
  EXPECT_TRUE(fit_line_error({}, LineError::Axis::kColumns, 128, kLines, 8).error.none());
}

}  // namespace
}  // namespace reseau
