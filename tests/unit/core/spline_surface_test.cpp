#include "core/screen/spline_surface.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace reseau {
namespace {

constexpr int kWidth = 700, kHeight = 500;

ScatteredValues sampled(double noise, double (*truth)(double, double)) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal(0, noise);
  ScatteredValues samples;
  for (int y = 8; y < kHeight; y += 32) {
    for (int x = 8; x < kWidth; x += 32) {
      samples.positions.push_back({static_cast<double>(x), static_cast<double>(y)});
      samples.values.push_back(truth(x, y) + normal(random));
      samples.weights.push_back(1 / (noise * noise));
    }
  }
  return samples;
}

double rms(const SplineSurface& surface, double (*truth)(double, double)) {
  double sum = 0;
  int n = 0;
  for (int y = 0; y < kHeight; y += 11) {
    for (int x = 0; x < kWidth; x += 11, ++n) {
      sum +=
          std::pow(surface.at({static_cast<double>(x), static_cast<double>(y)}) - truth(x, y), 2);
    }
  }
  return std::sqrt(sum / n);
}

TEST(SplineSurface, NoiseAloneStaysFlat) {
  const ScatteredValues samples = sampled(0.01, [](double, double) { return 0.0; });
  SurfaceLevels levels = surface_levels(kWidth, kHeight, 40);
  choose_levels({&samples}, kWidth, kHeight, levels);
  EXPECT_TRUE(levels.flat());
}

TEST(SplineSurface, FollowsASmoothBendBelowTheNoise) {
  const auto bend = [](double x, double y) { return 0.4 * std::sin(x / 210) * std::cos(y / 300); };
  const ScatteredValues samples = sampled(0.01, bend);
  SurfaceLevels levels = surface_levels(kWidth, kHeight, 40);
  choose_levels({&samples}, kWidth, kHeight, levels);
  ASSERT_FALSE(levels.flat());
  EXPECT_LT(rms(fit_surface(samples, kWidth, kHeight, levels), bend), 0.006);
}

TEST(SplineSurface, FollowsAWobbleThatCoarseLevelsCannot) {
  const auto wobble = [](double, double y) { return 0.1 * std::sin(y * 6.2831853 / 220); };
  const ScatteredValues samples = sampled(0.003, wobble);
  SurfaceLevels levels = surface_levels(kWidth, kHeight, 40);
  choose_levels({&samples}, kWidth, kHeight, levels);
  EXPECT_LT(rms(fit_surface(samples, kWidth, kHeight, levels), wobble), 0.006);
}

// Adding the levels up by refinement must give what each gives alone.
TEST(SplineSurface, LevelsAddUpExactly) {
  const auto bend = [](double x, double y) { return 1e-3 * x + 0.2 * std::sin(y / 90); };
  const ScatteredValues samples = sampled(0.01, bend);
  SurfaceLevels coarse = surface_levels(kWidth, kHeight, 40);
  coarse.stiffness[0] = 1;
  SurfaceLevels cut = coarse;
  cut.spacing_px.resize(1);
  cut.stiffness.resize(1);
  const SplineSurface refined = fit_surface(samples, kWidth, kHeight, coarse);
  const SplineSurface alone = fit_surface(samples, kWidth, kHeight, cut);
  for (int y = 0; y < kHeight; y += 37) {
    for (int x = 0; x < kWidth; x += 41) {
      const Vec2 p{static_cast<double>(x), static_cast<double>(y)};
      EXPECT_NEAR(refined.at(p), alone.at(p), 1e-9) << x << ", " << y;
    }
  }
}

}  // namespace
}  // namespace reseau
