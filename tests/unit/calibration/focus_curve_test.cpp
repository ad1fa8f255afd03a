#include "calibration/focus/focus_curve.h"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace reseau {
namespace {

// A Gaussian that grows in quadrature: ln M is a parabola.
std::vector<FocusPoint> sweep(double best, double noise, unsigned seed, double fourth = 0) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<FocusPoint> out;
  for (int position = 170; position <= 250; position += 10) {
    const double u = position - best;
    const double m = 0.6 * std::exp(-2e-4 * u * u - fourth * u * u * u * u);
    out.push_back(
        {static_cast<double>(position), m + noise * normal(random), std::max(noise, 1e-6)});
  }
  return out;
}

TEST(FocusCurve, FindsThePeakAndTheDepth) {
  for (const double fourth : {0.0, 4e-8}) {
    const FocusFit fit = fit_focus(sweep(213.7, 0, 1, fourth));
    ASSERT_TRUE(fit.ok) << fit.why;
    EXPECT_NEAR(fit.best.value, 213.7, 1e-3);
    EXPECT_NEAR(fit.peak.value, 0.6, 1e-5);
    ASSERT_TRUE(fit.half_depth);
    const double h = fit.half_depth->value;
    EXPECT_NEAR(2e-4 * h * h + fourth * h * h * h * h, -std::log(kDepthShare), 1e-4);
  }
}

TEST(FocusCurve, DeviationsAreHonest) {
  double best = 0, depth = 0;
  constexpr int kSweeps = 200;
  const double truth = std::sqrt(-std::log(kDepthShare) / 2e-4);
  for (int i = 0; i < kSweeps; ++i) {
    const FocusFit fit = fit_focus(sweep(208, 0.004, static_cast<unsigned>(i + 1)));
    ASSERT_TRUE(fit.ok && fit.half_depth);
    best += std::pow((fit.best.value - 208) / fit.best.sd, 2);
    depth += std::pow((fit.half_depth->value - truth) / fit.half_depth->sd, 2);
  }
  // Deviations never shrink below what the points claim, so z stays a little under one.
  EXPECT_GT(std::sqrt(best / kSweeps), 0.7);
  EXPECT_LT(std::sqrt(best / kSweeps), 1.2);
  EXPECT_GT(std::sqrt(depth / kSweeps), 0.7);
  EXPECT_LT(std::sqrt(depth / kSweeps), 1.3);
}

TEST(FocusCurve, SaysWhyThereIsNone) {
  EXPECT_FALSE(fit_focus({}).ok);
  std::vector<FocusPoint> two = sweep(208, 0, 1);
  two.resize(2);
  EXPECT_FALSE(fit_focus(two).ok);
  // All on one side of the peak.
  const FocusFit aside = fit_focus(sweep(320, 1e-4, 1));
  EXPECT_FALSE(aside.ok);
  EXPECT_NE(aside.why.find("no peak"), std::string::npos);
  std::vector<FocusPoint> flat = sweep(208, 0, 1);
  for (FocusPoint& p : flat) p.modulation = 0.5;
  EXPECT_FALSE(fit_focus(flat).ok);
  for (FocusPoint& p : flat) p.modulation = std::nan("");
  EXPECT_FALSE(fit_focus(flat).ok);
}

}  // namespace
}  // namespace reseau
