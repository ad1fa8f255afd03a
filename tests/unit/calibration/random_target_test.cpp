// Random targets seen through a known spread, exactly: a Gaussian's share of each cell.
#include "calibration/random/random_target.h"

#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace reseau {
namespace {

struct Seen {
  double sigma_x = 0.75, sigma_y = 0.75;
  Vec2 origin{3.37, -1.81};  // of the first pixel's centre, in the target
  double scale_x = 1, scale_y = 1, noise = 0.01;
  unsigned seed = 1;
};

double share(double from, double to, double at, double sigma) {
  const double s = sigma * std::numbers::sqrt2;
  return 0.5 * (std::erf((to - at) / s) - std::erf((from - at) / s));
}

std::vector<float> picture(const RandomTarget& target, int side, const Seen& seen) {
  std::mt19937 random(seen.seed);
  std::normal_distribution<double> normal;
  std::vector<float> out;
  const double cell = target.cell_px;
  for (int y = 0; y < side; ++y) {
    const double v = seen.origin.y + seen.scale_y * y;
    for (int x = 0; x < side; ++x) {
      const double u = seen.origin.x + seen.scale_x * x;
      double light = 0;
      const auto row0 = static_cast<long>(std::floor((v - 5) / cell)),
                 rows = std::lround(10 / cell);
      const auto col0 = static_cast<long>(std::floor((u - 5) / cell)), cols = rows;
      for (long j = row0; j <= row0 + rows; ++j) {
        const double wy = share(double(j) * cell, double(j + 1) * cell, v, seen.sigma_y);
        if (wy < 1e-12) continue;
        for (long i = col0; i <= col0 + cols; ++i) {
          if (!random_cell(target.seed, i, j)) continue;
          light += wy * share(double(i) * cell, double(i + 1) * cell, u, seen.sigma_x);
        }
      }
      out.push_back(static_cast<float>(0.1 + 0.6 * (light + seen.noise * normal(random))));
    }
  }
  return out;
}

// Of all samples together, against the Gaussian.
double error_of(const RandomPsf& psf, const Seen& seen) {
  double squares = 0, all = 0;
  for (int y = 0; y < psf.side; ++y) {
    for (int x = 0; x < psf.side; ++x) {
      const double dx = (x - psf.side / 2) * psf.step_px, dy = (y - psf.side / 2) * psf.step_px;
      // The place of the picture is known to the test; the fit may put the spread elsewhere.
      const double truth = std::exp(-dx * dx / (2 * seen.sigma_x * seen.sigma_x) -
                                    dy * dy / (2 * seen.sigma_y * seen.sigma_y)) /
                           (2 * std::numbers::pi * seen.sigma_x * seen.sigma_y);
      squares += std::pow(psf.psf[static_cast<std::size_t>(y * psf.side + x)] - truth, 2);
      all += truth * truth;
    }
  }
  return std::sqrt(squares / all);
}

RandomPsf measure(const RandomTarget& target, int side, const Seen& seen, Vec2 start) {
  const std::vector<float> samples = picture(target, side, seen);
  RandomOptions options;
  options.start_px = start;
  options.search_px = 6;
  return measure_random(Span2D<const float>(samples.data(), side, side), target, options);
}

TEST(RandomTarget, FindsPlaceAndTransferWithDeviations) {
  const RandomTarget target{11, 0.5};
  Seen seen;
  seen.sigma_y = 0.9;
  seen.scale_x = 1.002;
  const RandomPsf psf = measure(target, 96, seen, {1, 1});
  ASSERT_TRUE(psf.ok) << psf.why;
  std::printf("place off by %.4f %.4f px (sd %.4f %.4f), sd of all %.2f %%\n",
              psf.origin_px.x - seen.origin.x, psf.origin_px.y - seen.origin.y, psf.origin_sd_px.x,
              psf.origin_sd_px.y, 100 * psf.sd_of_all);
  EXPECT_NEAR(psf.origin_px.x, seen.origin.x, 0.01);
  EXPECT_NEAR(psf.origin_px.y, seen.origin.y, 0.01);
  EXPECT_NEAR(psf.scale.a, seen.scale_x, 1e-4);
  EXPECT_NEAR(psf.scale.d, 1, 1e-4);
  EXPECT_NEAR(psf.noise, seen.noise, 0.05 * seen.noise);
  for (const double f : {0.1, 0.2, 0.3}) {
    const double t = 2 * std::pow(std::numbers::pi * f, 2);
    EXPECT_NEAR(psf.mtf(f, 0), std::exp(-t * seen.sigma_x * seen.sigma_x), 0.01) << f;
    EXPECT_NEAR(psf.mtf(0, f), std::exp(-t * seen.sigma_y * seen.sigma_y), 0.01) << f;
  }
}

// In its own place the spread is as close to the truth as its deviations say.
TEST(RandomTarget, TheSpreadIsAsCloseAsItSays) {
  const RandomTarget target{5, 0.5};
  double squares = 0, claimed = 0;
  constexpr int kPictures = 4;
  for (unsigned i = 1; i <= kPictures; ++i) {
    Seen seen;
    seen.origin = {0, 0};  // the search ends there, and the fit stays within a hundredth
    seen.seed = i;
    const RandomPsf psf = measure(target, 96, seen, {0, 0});
    ASSERT_TRUE(psf.ok) << psf.why;
    squares += std::pow(error_of(psf, seen), 2);
    claimed += psf.sd_of_all * psf.sd_of_all;
  }
  const double error = std::sqrt(squares / kPictures), sd = std::sqrt(claimed / kPictures);
  std::printf("2-D spread, 96 x 96 px, noise 1 %%: error %.2f %%, claimed %.2f %%\n", 100 * error,
              100 * sd);
  EXPECT_LT(error, 1.2 * sd);
  EXPECT_GT(error, 0.8 * sd);
}

TEST(RandomTarget, SaysWhatCannotBeTold) {
  // Cells as large as pixels, in step with them.
  Seen seen;
  seen.origin = {0.5, 0.5};
  const RandomPsf in_step = measure({3, 1.0}, 64, seen, {0.5, 0.5});
  EXPECT_FALSE(in_step.ok);
  EXPECT_NE(in_step.why.find("repeat the pixels"), std::string::npos) << in_step.why;
  // Another target, nothing at all, too small.
  const std::vector<float> other = picture({77, 0.5}, 64, {});
  EXPECT_FALSE(measure_random(Span2D<const float>(other.data(), 64, 64), {3, 0.5}).ok);
  EXPECT_FALSE(measure_random(Span2D<const float>(other.data(), 20, 20, 64), {77, 0.5}).ok);
  const std::vector<float> nothing(64 * 64, std::numeric_limits<float>::quiet_NaN());
  EXPECT_FALSE(measure_random(Span2D<const float>(nothing.data(), 64, 64), {3, 0.5}).ok);
}

}  // namespace
}  // namespace reseau
