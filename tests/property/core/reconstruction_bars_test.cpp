// The colour of whole reconstructions of simulated films, everything automatic, against the scene.
// The bounds are those that the product promises, but of the drifting focus, where flat colours
// miss them: there they are what is reached and a little. core/README.md says what is reached.
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "capture/bench/reconstruction_bench.h"

namespace reseau {
namespace {

struct Bars {
  const char* film;
  Quality quality;
  double element, full, psnr_db, patch_mean, patch_max;  // full and psnr: 0 = no bar
};

class ReconstructionBars : public testing::TestWithParam<Bars> {};

TEST_P(ReconstructionBars, AreKept) {
  const Bars& bars = GetParam();
  const ReconstructionRun run = run_reconstruction_case({"", bars.film}, bars.quality, false, 0);
  ASSERT_TRUE(run.found) << run.reason;
  fmt::print("{}: full {:.2f} ({:.1f} dB), element {:.2f}, patches {:.3f} / {:.3f} of {}\n",
             bars.film, run.score.full_mean, run.score.psnr_db, run.score.element_mean,
             run.score.patch_mean, run.score.patch_max, run.score.n_patches);
  EXPECT_LE(run.score.element_mean, bars.element);
  if (bars.full > 0) {
    EXPECT_LE(run.score.full_mean, bars.full);
    EXPECT_GE(run.score.psnr_db, bars.psnr_db);
  }
  EXPECT_LE(run.score.patch_mean, bars.patch_mean);
  EXPECT_LE(run.score.patch_max, bars.patch_max);
}

constexpr const char* kChart = "scene=chart&blur_px=0.6&ir_blur_px=0.6&noise=0.0005";
constexpr const char* kNatural = "scene=natural&blur_px=0.6&ir_blur_px=0.6&noise=0.006";
constexpr const char* kSoft = "scene=chart&blur_px=1&ir_blur_px=1&noise=0.0005";
constexpr const char* kSofter = "scene=chart&blur_px=1.5&ir_blur_px=1.5&noise=0.0005";
constexpr const char* kDrifting =
    "scene=chart&blur_px=0.4&ir_blur_px=0.4&noise=0.0005&f_number=4&focus_um=68&focus_tilt_um=68";

INSTANTIATE_TEST_SUITE_P(OneMegapixel, ReconstructionBars,
                         testing::Values(Bars{kChart, Quality::kStandard, 1.5, 0, 0, 0.2, 0.6},
                                         Bars{kChart, Quality::kBest, 1.15, 2.3, 30, 0.2, 0.6},
                                         Bars{kNatural, Quality::kStandard, 1.5, 0, 0, 1, 1},
                                         Bars{kNatural, Quality::kBest, 1.3, 3.0, 30.5, 1, 1},
                                         Bars{kSoft, Quality::kStandard, 1.7, 0, 0, 0.2, 0.7},
                                         Bars{kSoft, Quality::kBest, 1.4, 0, 0, 0.2, 0.7},
                                         Bars{kSofter, Quality::kStandard, 2.1, 0, 0, 0.4, 1.2},
                                         Bars{kSofter, Quality::kBest, 1.0, 2.1, 33, 0.4, 1.2},
                                         Bars{kDrifting, Quality::kStandard, 2.0, 0, 0, 1.2, 2.9},
                                         Bars{kDrifting, Quality::kBest, 1.4, 0, 0, 0.85, 2.8}));

}  // namespace
}  // namespace reseau
