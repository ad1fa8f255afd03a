#include "core/screen/blur_shape.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace reseau {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(BlurShape, IsARoundGaussianUnlessToldOtherwise) {
  const BlurShape shape;
  for (const double f : {0.0, 0.05, 0.13, 0.4}) {
    EXPECT_NEAR(shape.transfer({0.6 * f, -0.8 * f}, 0.9), std::exp(-2 * kPi * kPi * 0.81 * f * f),
                1e-12);
  }
}

// The mean of a wave over a disc, added up from its chords.
double disc_transfer(double radius_px, double f) {
  constexpr int kChords = 20000;
  double sum = 0, area = 0;
  for (int i = 0; i < kChords; ++i) {
    const double x = (2 * (i + 0.5) / kChords - 1) * radius_px;
    const double chord = std::sqrt(radius_px * radius_px - x * x);
    sum += chord * std::cos(2 * kPi * f * x);
    area += chord;
  }
  return sum / area;
}

TEST(BlurShape, WhatIsWiderThanInFocusIsADisc) {
  BlurShape shape;
  shape.in_focus_px = 0.5;
  constexpr double kSigma = 1.3;
  const double radius = 2 * std::sqrt(kSigma * kSigma - 0.25);
  bool reversed = false;
  for (const double f : {0.02, 0.1, 0.18, 0.26, 0.35}) {
    const double truth = disc_transfer(radius, f) * std::exp(-2 * kPi * kPi * 0.25 * f * f);
    EXPECT_NEAR(shape.transfer({f, 0}, kSigma), truth, 1e-6) << f;
    EXPECT_NEAR(shape.transfer({0, f}, kSigma), truth, 1e-6) << f;
    reversed = reversed || truth < -0.01;
  }
  EXPECT_TRUE(reversed) << "a disc reverses contrast beyond its first zero";
  EXPECT_NEAR(shape.transfer({0.2, 0}, 0.4), BlurShape{}.transfer({0.2, 0}, 0.4), 1e-12);
  EXPECT_NEAR(shape.transfer({0, 0}, kSigma), 1, 1e-12);
}

TEST(BlurShape, StretchesAlongAnAxis) {
  BlurShape shape;
  shape.stretch = 0.3;
  const BlurShape round;
  EXPECT_NEAR(shape.transfer({0.2, 0}, 0.8), round.transfer({0.2, 0}, 0.8 * std::sqrt(1.3)), 1e-12);
  EXPECT_NEAR(shape.transfer({0, 0.2}, 0.8), round.transfer({0, 0.2}, 0.8 * std::sqrt(0.7)), 1e-12);
}

TEST(BlurShape, LightThatGoesFarIsMissingAtEveryFrequencyButZero) {
  BlurShape shape;
  shape.far_share = 0.1;
  EXPECT_EQ(shape.transfer({0, 0}, 0.8), 1);
  EXPECT_NEAR(shape.transfer({0.1, 0.1}, 0.8), 0.9 * BlurShape{}.transfer({0.1, 0.1}, 0.8), 1e-12);
}

}  // namespace
}  // namespace reseau
