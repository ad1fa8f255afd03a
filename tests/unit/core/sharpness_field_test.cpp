#include "core/reconstruct/sharpness_field.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace reseau {
namespace {

constexpr Vec2 kFrame{4000, 6000};

// Samples of a blur with noise, every eighth far off.
template <typename Sigma>
std::vector<BlurSample> samples_of(const Sigma& sigma, double sd_px, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, sd_px);
  std::vector<BlurSample> samples;
  for (int j = 0; j < 12; ++j) {
    for (int i = 0; i < 12; ++i) {
      const Vec2 p{(i + 0.5) / 12 * kFrame.x, (j + 0.5) / 12 * kFrame.y};
      double s = sigma(p) + noise(random);
      if ((i + 12 * j) % 8 == 0) s += 0.4;
      samples.push_back({p, s * s, 2 * s * sd_px});
    }
  }
  return samples;
}

TEST(BlurSurface, TermsAreThePowers) {
  std::array<double, 15> t{};
  ASSERT_EQ(BlurSurface::terms(2, 3, 4, t), 15U);
  const std::array<double, 15> expected{1, 2, 3, 4, 6, 9, 8, 12, 18, 27, 16, 24, 36, 54, 81};
  EXPECT_EQ(t, expected);
}

TEST(BlurSurface, ConstantBlurStaysConstant) {
  const BlurSurface found =
      fit_blur_surface(samples_of([](Vec2) { return 0.67; }, 0.01, 3), kFrame, 4, nullptr);
  EXPECT_EQ(found.degree(), 0);
  EXPECT_NEAR(found.sigma_px({100, 100}), 0.67, 0.003);
}

TEST(BlurSurface, FollowsDefocusThroughTheBestPlane) {
  const auto sigma = [](Vec2 p) {
    const double z = 2 * p.y / kFrame.y - 0.7;
    return std::sqrt(0.25 + 1.1 * z * z);
  };
  const BlurSurface found = fit_blur_surface(samples_of(sigma, 0.01, 5), kFrame, 4, nullptr);
  for (double y = 250; y < kFrame.y; y += 500) {
    for (double x = 250; x < kFrame.x; x += 500)
      EXPECT_NEAR(found.sigma_px({x, y}), sigma({x, y}), 0.02) << x << ", " << y;
  }
  const auto range = found.range_px();
  EXPECT_NEAR(range[0], 0.5, 0.03);
  EXPECT_NEAR(range[1], std::sqrt(0.25 + 1.1 * 1.3 * 1.3), 0.1);
}

TEST(BlurSurface, ClaimsTheUncertaintyThatItHas) {
  const auto sigma = [](Vec2 p) { return std::sqrt(0.3 + 0.5 * p.x / kFrame.x); };
  double squares = 0;
  int n = 0;
  for (unsigned seed = 20; seed < 60; ++seed) {
    const BlurSurface found = fit_blur_surface(samples_of(sigma, 0.02, seed), kFrame, 4, nullptr);
    ASSERT_GT(found.degree(), 0);
    for (const Vec2 p : {Vec2{500, 700}, Vec2{2000, 3000}, Vec2{3500, 4500}}) {
      const double sd = found.sd_px(p);
      ASSERT_GT(sd, 0);
      const double z = (found.sigma_px(p) - sigma(p)) / sd;
      squares += z * z;
      ++n;
    }
  }
  const double z = std::sqrt(squares / n);
  EXPECT_GT(z, 0.75);
  EXPECT_LT(z, 1.3);
  EXPECT_EQ(BlurSurface(0.7).sd_px({1, 1}), 0) << "nothing is known of a constant's";
}

TEST(BlurSurface, ThePoorChannelBorrowsTheShapeOfTheOthers) {
  const auto sigma = [](Vec2 p) { return std::sqrt(0.3 + 0.5 * p.x / kFrame.x); };
  const BlurSurface rgb = fit_blur_surface(samples_of(sigma, 0.005, 6), kFrame, 4, nullptr);
  const auto softer = [&](Vec2 p) { return std::sqrt(sigma(p) * sigma(p) + 0.13); };
  std::vector<BlurSample> few = samples_of(softer, 0.03, 7);
  few.resize(20);  // two rows at the top
  const BlurSurface found = fit_blur_surface(few, kFrame, 2, &rgb);
  // All of the width is seen, so the range is too.
  EXPECT_NEAR(found.sigma_px({3800, 5500}), softer({3800, 5500}), 0.05);
  EXPECT_NEAR(found.sigma_px({300, 5500}), softer({300, 5500}), 0.05);
}

}  // namespace
}  // namespace reseau
