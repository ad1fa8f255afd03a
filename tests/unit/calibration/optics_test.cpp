// The physical profile against closed forms and against the independent renderer's transfer.
#include "calibration/edge/optics.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "calibration/edge/mean_profile.h"
#include "tests/support/edge_renderer.h"

namespace reseau {
namespace {

constexpr double kPi = std::numbers::pi;

EdgeOptics plain() { return {.diffraction_px = 0, .sigma2_px2 = 0.5, .aperture2_px2 = 0}; }

TEST(EdgeOptics, AgreesWithAnIndependentLens) {
  const double q = 0.55 * 8 / 4.73;
  for (const double w20 : {0.0, 0.3, 0.8}) {
    const test::Transfer2D truth = test::airy_box_transfer(8, w20);
    EdgeOptics optics{.diffraction_px = q, .sigma2_px2 = 0, .aperture2_px2 = 1};
    optics.w20_waves = w20;
    const NormalCosines normal{std::cos(0.3), std::sin(0.3)};
    for (double f = 0.01; f < 1.1; f += 0.07) {
      EXPECT_NEAR(transfer(optics, normal, f), truth(f * normal.x, f * normal.y), 3e-6)
          << w20 << " waves at " << f;
    }
  }
}

TEST(EdgeOptics, DerivativesAreThoseOfTheFunction) {
  const EdgeOptics at{.diffraction_px = 0.9,
                      .sigma2_px2 = 0.1,
                      .aperture2_px2 = 2,
                      .smear2_px2 = 1.5,
                      .w20_waves = 0.4,
                      .halo = 0.1,
                      .halo_sigma_px = 3,
                      .aspect2 = 1.7};
  const int all[] = {kDiffraction, kSigma2, kAperture2, kSmear2, kW20, kHalo, kHaloSigma, kAspect2};
  const NormalCosines normal{0.8, 0.6};
  for (const double f : {0.05, 0.3, 0.77}) {
    std::array<double, 1 + kOpticsParameters> out{};
    transfer(at, normal, f, all, out);
    for (std::size_t i = 0; i < std::size(all); ++i) {
      constexpr double kStep = 1e-5;
      EdgeOptics up = at, down = at;
      parameter(up, all[i]) += kStep;
      parameter(down, all[i]) -= kStep;
      const double numeric = (transfer(up, normal, f) - transfer(down, normal, f)) / (2 * kStep);
      EXPECT_NEAR(out[1 + i], numeric, 1e-7) << "parameter " << all[i] << " at " << f;
    }
  }
}

TEST(EdgeOptics, ContinuesSmoothlyBelowZero) {
  for (const int p : {kDiffraction, kSigma2, kAperture2}) {
    EdgeOptics up = plain(), down = plain();
    parameter(up, p) = 1e-6;
    parameter(down, p) = -1e-6;
    EdgeOptics zero = plain();
    parameter(zero, p) = 0;
    const double a = transfer(up, {}, 0.4), b = transfer(zero, {}, 0.4),
                 c = transfer(down, {}, 0.4);
    EXPECT_NEAR(a - b, b - c, 1e-9) << p;
    EXPECT_LT(a, b) << p;
  }
}

TEST(MeanProfile, OfAGaussianIsTheErrorFunction) {
  const MeanProfile profile(plain(), {}, 36, {});
  for (double d = -30; d < 30; d += 0.37) {
    EXPECT_NEAR(profile.value(d), 0.5 * std::erfc(-d), 2e-7) << d;
    EXPECT_NEAR(profile.slope(d), std::exp(-d * d) / std::sqrt(kPi), 2e-5) << d;
  }
}

// Lens and aperture: a long tail, of which nothing may be lost.
TEST(MeanProfile, KeepsTheTailOfALens) {
  const EdgeOptics optics{.diffraction_px = 0.9, .sigma2_px2 = 0, .aperture2_px2 = 1};
  const MeanProfile near(optics, {}, 30, {}), far(optics, {}, 90, {});
  for (double d = 1; d < 30; d += 1.7) EXPECT_NEAR(near.value(d), far.value(d), 2e-7) << d;
  // Far out it falls off as 2 q / (pi^3 d).
  const double d = 80;
  EXPECT_NEAR((1 - far.value(d)) * d, 2 * 0.9 / (kPi * kPi * kPi), 1e-4);
}

}  // namespace
}  // namespace reseau
