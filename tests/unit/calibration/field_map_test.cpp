#include "calibration/psf/field_map.h"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace reseau {
namespace {

double truth(double x, double y) { return 0.05 + 0.04 * x - 0.02 * y + 0.06 * x * x; }

std::vector<FieldSample> samples(double sd, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<FieldSample> out;
  for (const double y : {-0.9, -0.3, 0.3, 0.9}) {
    for (const double x : {-0.9, -0.3, 0.3, 0.9}) {
      out.push_back({x, y, truth(x, y) + sd * normal(random), sd});
    }
  }
  return out;
}

TEST(FieldMap, FollowsTheFieldWithHonestDeviations) {
  double squares = 0;
  int n = 0;
  for (unsigned seed = 1; seed <= 100; ++seed) {
    const auto field = fit_field(samples(0.004, seed));
    ASSERT_TRUE(field);
    EXPECT_EQ(field->order, 2);
    for (const double x : {-0.5, 0.0, 0.7}) {
      const Measured at = field->at(x, 0.2);
      EXPECT_LT(at.sd, 0.004);
      squares += std::pow((at.value - truth(x, 0.2)) / at.sd, 2);
      ++n;
    }
  }
  EXPECT_GT(std::sqrt(squares / n), 0.75);
  EXPECT_LT(std::sqrt(squares / n), 1.2);
}

TEST(FieldMap, TakesNoMoreTermsThanThereAre) {
  EXPECT_FALSE(fit_field({}));
  std::vector<FieldSample> few = samples(0.004, 3);
  few.resize(4);
  EXPECT_EQ(fit_field(few)->order, 0);
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  int curved = 0;
  for (int i = 0; i < 50; ++i) {
    std::vector<FieldSample> even = samples(0.004, 1);
    for (FieldSample& s : even) s.value = 0.1 + 0.004 * normal(random);
    curved += fit_field(even)->order > 0 ? 1 : 0;
  }
  EXPECT_LE(curved, 12);
}

TEST(FieldMap, AnEdgeShowsWhatIsOnTopOfTheModel) {
  EdgeOptics shared;
  shared.diffraction_px = 0.5;
  shared.sigma2_px2 = 0.1;
  const NormalCosines normal{0.99, std::sqrt(1 - 0.99 * 0.99)};
  EdgeOptics here = shared;
  here.sigma2_px2 = 0.17;
  double low = 0.01, high = 1;
  for (int i = 0; i < 60; ++i) {
    const double f = (low + high) / 2;
    (transfer(here, normal, f) > 0.5 ? low : high) = f;
  }
  const double slope = (transfer(here, normal, low + 1e-4) - 0.5) / 1e-4;
  const auto extra = extra_variance(shared, normal, low, 0.001, slope);
  ASSERT_TRUE(extra);
  EXPECT_NEAR(extra->value, 0.07, 1e-6);
  // The same by the change of the place of one half.
  const double away = extra_variance(shared, normal, low + 1e-5, 0.001, slope)->value;
  const double moved = std::abs(away - extra->value) / 1e-5 * 0.001;
  EXPECT_LT(extra->sd, 3 * moved);
  EXPECT_GT(extra->sd, moved / 3);
}

}  // namespace
}  // namespace reseau
