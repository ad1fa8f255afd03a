// What a scan shows of its own sharpness, on films whose optics are known.
#include <cmath>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "capture/bench/reconstruction_bench.h"

namespace reseau {
namespace {

TEST(SharpnessOfAScan, TellsTheTwoAxesApart) {
  // Apertures of 1 and 2 px, each a variance of a twelfth of its square, and a Gaussian of 0.4 px.
  const double x = 0.16 + 1.0 / 12, y = 0.16 + 4.0 / 12;
  const ReconstructionRun run = run_reconstruction_case(
      {"", "scene=chart&blur_px=0.4&ir_blur_px=0.4&noise=0.0005&aperture_y_px=2"},
      Quality::kStandard, false, 0);
  ASSERT_TRUE(run.found) << run.reason;
  const SharpnessReport& sharpness = run.report.sharpness;
  fmt::print("stretch {:.3f} +- {:.3f}, truth {:.3f}; patches {:.3f} / {:.3f}\n", sharpness.stretch,
             sharpness.stretch_sd, (x - y) / (x + y), run.score.patch_mean, run.score.patch_max);
  EXPECT_NEAR(sharpness.stretch, (x - y) / (x + y), 0.03);
  for (const double sigma : sharpness.sigma_px) EXPECT_NEAR(sigma, std::sqrt(0.5 * (x + y)), 0.015);
  EXPECT_LE(run.score.patch_mean, 0.2);
  EXPECT_LE(run.score.patch_max, 0.6);
}

TEST(SharpnessOfAScan, FollowsABlurThatDriftsAcrossTheFilm) {
  for (const Quality quality : {Quality::kStandard, Quality::kBest}) {
    const ReconstructionRun run = run_reconstruction_case(
        {"", "scene=chart&blur_px=0.4&ir_blur_px=0.4&noise=0", BlurDrift{0.4, 1.4, 0.0005}},
        quality, false, 0);
    ASSERT_TRUE(run.found) << run.reason;
    fmt::print("element {:.2f}, patches {:.3f} / {:.3f}\n", run.score.element_mean,
               run.score.patch_mean, run.score.patch_max);
    EXPECT_LE(run.score.element_mean, quality == Quality::kBest ? 1.4 : 1.7);
    EXPECT_LE(run.score.patch_mean, 0.3);
    EXPECT_LE(run.score.patch_max, 1.0);
    EXPECT_TRUE(std::isinf(run.report.sharpness.in_focus_px)) << "a Gaussian is not a disc";
  }
}

TEST(SharpnessOfAScan, KnowsADiscOfDefocus) {
  // At f/1 a disc of 2.7 px at one side and next to none at the other: no Gaussian at all.
  const ReconstructionRun run = run_reconstruction_case(
      {"",
       "scene=chart&blur_px=0.4&ir_blur_px=0.4&noise=0.0005&f_number=1&focus_um=17&"
       "focus_tilt_um=17"},
      Quality::kStandard, false, 0);
  ASSERT_TRUE(run.found) << run.reason;
  fmt::print("in focus {:.2f} px; patches {:.3f} / {:.3f}\n", run.report.sharpness.in_focus_px,
             run.score.patch_mean, run.score.patch_max);
  EXPECT_LT(run.report.sharpness.in_focus_px, 0.75);
  // As Gaussians: 1.3 / 11.8.
  EXPECT_LE(run.score.patch_mean, 0.6);
  EXPECT_LE(run.score.patch_max, 1.5);
}

}  // namespace
}  // namespace reseau
