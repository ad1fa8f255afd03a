#include "calibration/edge/residual_spline.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

namespace reseau {
namespace {

std::vector<double> some_coefficients(std::size_t n) {
  std::vector<double> out(n);
  for (std::size_t i = 0; i < n; ++i) out[i] = std::sin(1.7 * double(i) + 0.3);
  return out;
}

TEST(ResidualSpline, DerivativesAreThoseOfTheValue) {
  const ResidualSpline spline(0.3, 3, 30);
  const std::vector<double> c = some_coefficients(spline.size());
  for (const double d : {-25.1, -3.3, -0.02, 0.4, 2.9, 11.0}) {
    constexpr double kStep = 1e-4;
    for (int k = 0; k < 3; ++k) {
      const double numeric =
          (spline.value(c, d + kStep, k) - spline.value(c, d - kStep, k)) / (2 * kStep);
      EXPECT_NEAR(spline.value(c, d, k + 1), numeric, 1e-4 * std::max(1.0, std::abs(numeric)))
          << d << " derivative " << k + 1;
    }
  }
}

TEST(ResidualSpline, IsZeroAtItsEnds) {
  const ResidualSpline spline(0.25, 3, 20);
  const std::vector<double> c = some_coefficients(spline.size());
  for (const double d : {-40.0, 40.0}) EXPECT_EQ(spline.value(c, d), 0);
}

TEST(ResidualSpline, TransformIsTheIntegralOfTheSlope) {
  const ResidualSpline spline(0.3, 3, 25);
  const std::vector<double> c = some_coefficients(spline.size());
  std::vector<double> re(c.size()), im(c.size());
  for (const double f : {0.01, 0.1, 0.33, 0.9}) {
    spline.transform(f, re, im);
    double real = 0, imaginary = 0;
    for (std::size_t i = 0; i < c.size(); ++i) {
      real += c[i] * re[i];
      imaginary += c[i] * im[i];
    }
    double numeric_real = 0, numeric_imaginary = 0;
    constexpr double kStep = 1.0 / 512;
    for (double d = -32; d <= 32; d += kStep) {
      const double slope = spline.value(c, d, 1) * kStep;
      numeric_real += slope * std::cos(2 * std::numbers::pi * f * d);
      numeric_imaginary -= slope * std::sin(2 * std::numbers::pi * f * d);
    }
    EXPECT_NEAR(real, numeric_real, 1e-5) << f;
    EXPECT_NEAR(imaginary, numeric_imaginary, 1e-5) << f;
  }
}

TEST(ResidualSpline, RoughnessIsPositive) {
  const ResidualSpline spline(0.25, 3, 30);
  EXPECT_TRUE(Cholesky(spline.roughness(0.7)).ok());
}

}  // namespace
}  // namespace reseau
