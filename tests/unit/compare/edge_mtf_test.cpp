// The transfer function of edges whose profile is known in closed form.
#include "capture/compare/edge_mtf.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace reseau::compare {
namespace {

struct EdgeScene {
  int width = 80, height = 64;
  double normal_deg = 8, offset_px = 0.3, sigma_px = 0.8;
  double low = 0.2, high = 0.7, noise = 0;
  unsigned seed = 1;
};

// Point samples of a step smoothed by a Gaussian: the profile is the error function, the transfer
// function exp(-2 (pi sigma f)^2).
std::vector<double> render(const EdgeScene& e) {
  std::mt19937 random(e.seed);
  std::normal_distribution<double> normal;
  std::vector<double> samples;
  const double a = e.normal_deg * std::numbers::pi / 180;
  for (int y = 0; y < e.height; ++y) {
    for (int x = 0; x < e.width; ++x) {
      const double d = (x - (e.width - 1) / 2.0) * std::cos(a) +
                       (y - (e.height - 1) / 2.0) * std::sin(a) - e.offset_px;
      const double share = 0.5 * std::erfc(-d / (e.sigma_px * std::numbers::sqrt2));
      samples.push_back(e.low + (e.high - e.low) * share +
                        e.noise * (e.high - e.low) * normal(random));
    }
  }
  return samples;
}

EdgeMtf measure(const EdgeScene& e) { return measure_edge(render(e), e.width, e.height); }

double gaussian_mtf50(double sigma) {
  return std::sqrt(std::numbers::ln2 / 2) / (std::numbers::pi * sigma);
}

TEST(EdgeMtf, GaussianEdgesOfAllAnglesAndWidths) {
  for (const double angle : {3.0, 5.7, 14.036, 22.0, 33.69, 41.0, -11.0, 95.0, 171.0}) {
    for (const double sigma : {0.5, 0.8, 2.0, 4.0}) {
      const EdgeScene scene{.normal_deg = angle, .sigma_px = sigma};
      const EdgeMtf mtf = measure(scene);
      SCOPED_TRACE(testing::Message() << angle << " degrees, sigma " << sigma);
      ASSERT_TRUE(mtf.ok()) << mtf.reason;
      EXPECT_NEAR(*mtf.mtf50_cy_per_px / gaussian_mtf50(sigma), 1, 0.005);
      EXPECT_NEAR(mtf.contrast, 0.5, 0.002);
      for (const int percent : {5, 10, 20, 30}) {
        const double f = percent / 100.0;
        EXPECT_NEAR(mtf.mtf[static_cast<std::size_t>(percent)],
                    std::exp(-2 * std::pow(std::numbers::pi * sigma * f, 2)), 0.004)
            << f;
      }
    }
  }
}

TEST(EdgeMtf, TellsAngleAndPosition) {
  const EdgeMtf mtf = measure({.normal_deg = 12.34, .offset_px = 1.75});
  ASSERT_TRUE(mtf.ok());
  EXPECT_NEAR(mtf.geometry.normal_deg, 12.34, 0.005);
  EXPECT_NEAR(mtf.geometry.offset_px, 1.75, 0.005);
  EXPECT_NEAR(mtf.angle_deg, 12.34, 0.005);
}

TEST(EdgeMtf, PolarityAndTranspositionChangeNothing) {
  const EdgeScene scene{.width = 72, .height = 72};
  const EdgeMtf plain = measure(scene);
  EdgeScene dark = scene;
  std::swap(dark.low, dark.high);
  EXPECT_NEAR(*measure(dark).mtf50_cy_per_px, *plain.mtf50_cy_per_px, 1e-6);
  const std::vector<double> samples = render(scene);
  std::vector<double> transposed;
  for (std::size_t x = 0; x < 72; ++x) {
    for (std::size_t y = 0; y < 72; ++y) transposed.push_back(samples[y * 72 + x]);
  }
  EXPECT_NEAR(*measure_edge(transposed, 72, 72).mtf50_cy_per_px, *plain.mtf50_cy_per_px, 1e-6);
}

TEST(EdgeMtf, NoiseOfOnePercentCostsFewPercent) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const EdgeMtf mtf = measure({.noise = 0.01, .seed = seed});
    ASSERT_TRUE(mtf.ok()) << mtf.reason;
    EXPECT_NEAR(*mtf.mtf50_cy_per_px / gaussian_mtf50(0.8), 1, 0.05) << seed;
    EXPECT_NEAR(mtf.residual, 0.01, 0.002) << seed;
  }
}

TEST(EdgeMtf, AHalfWidthDifferenceIsSeen) {
  // A control for the tolerance above: five percent more blur is five percent less MTF50.
  const double plain = *measure({.sigma_px = 1.0}).mtf50_cy_per_px;
  const double blurred = *measure({.sigma_px = 1.05}).mtf50_cy_per_px;
  EXPECT_NEAR(blurred / plain, 1 / 1.05, 0.002);
}

TEST(EdgeMtf, RefusesWhatIsNoEdge) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform;
  std::vector<double> flat(64 * 64, 0.4), noise(64 * 64), bar(64 * 64), circle(64 * 64);
  for (std::size_t i = 0; i < noise.size(); ++i) {
    const double x = static_cast<double>(i % 64), y = static_cast<double>(i / 64);
    noise[i] = uniform(random);
    const double d = x - 26 + 0.15 * y;
    bar[i] = d > 0 && d < 6 ? 1 : 0;
    circle[i] = std::hypot(x - 32, y - 32) < 14 ? 1 : 0;
  }
  EXPECT_FALSE(measure_edge(flat, 64, 64).ok());
  EXPECT_FALSE(measure_edge(noise, 64, 64).ok());
  EXPECT_FALSE(measure_edge(bar, 64, 64).ok());
  EXPECT_FALSE(measure_edge(circle, 64, 64).ok());
  EXPECT_EQ(measure({.normal_deg = 0}).status, "angle");
  EXPECT_EQ(measure({.normal_deg = 90}).status, "angle");
  EXPECT_EQ(measure({.width = 8, .height = 8}).status, "too-small");
  EXPECT_EQ(measure({.width = 11, .height = 400}).status, "too-small");
  for (const EdgeMtf& refused : {measure_edge({}, 0, 0), measure_edge(flat, 64, 64)}) {
    EXPECT_FALSE(refused.reason.empty());
    EXPECT_TRUE(refused.mtf.empty());
  }
}

TEST(EdgeMtf, LeavesOutWhatIsNotFinite) {
  const EdgeScene scene;
  std::vector<double> samples = render(scene);
  for (std::size_t i = 0; i < samples.size(); i += 37) samples[i] = NAN;
  const EdgeMtf mtf = measure_edge(samples, scene.width, scene.height);
  ASSERT_TRUE(mtf.ok()) << mtf.reason;
  EXPECT_NEAR(*mtf.mtf50_cy_per_px / gaussian_mtf50(0.8), 1, 0.01);
  std::ranges::fill(samples, NAN);
  EXPECT_FALSE(measure_edge(samples, scene.width, scene.height).ok());
}

}  // namespace
}  // namespace reseau::compare
