// Random targets seen through a known spread, exactly: a round Gaussian sees as much of a cell
// however the target is turned.
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

constexpr int kCells = 400;

constexpr Vec2 kGhost{1.1, 0.6};  // px, along the target's axes

struct Seen {
  double sigma_x = 0.75, sigma_y = 0.75;
  Vec2 middle{21.37, -34.81};  // of the picture, in the target
  double turn_deg = 0, scale = 1;
  bool mirrored = false;
  double noise = 0.01, light_x = 0, bow_px = 0;
  double ghost = 0;  // share of the light that falls beside, at kGhost

  unsigned seed = 1;
  [[nodiscard]] Mat2 target_from_scan() const {
    const double a = turn_deg * std::numbers::pi / 180;
    const Mat2 turn{scale * std::cos(a), -scale * std::sin(a), scale * std::sin(a),
                    scale * std::cos(a)};
    return mirrored ? turn * Mat2{-1, 0, 0, 1} : turn;
  }
};

double share(double from, double to, double at, double sigma) {
  const double s = sigma * std::numbers::sqrt2;
  return 0.5 * (std::erf((to - at) / s) - std::erf((from - at) / s));
}

// The definition of the target, once more.
bool is_clear(std::uint64_t seed, std::int64_t column, std::int64_t row) {
  if (column < 0 || row < 0 || column >= kCells || row >= kCells) return false;
  std::uint64_t z = seed * 0x9E3779B97F4A7C15U +
                    static_cast<std::uint64_t>(column) * 0xD1B54A32D192ED03U +
                    static_cast<std::uint64_t>(row) * 0x8CB92BA72F3D8DD7U;
  for (int i = 0; i < 2; ++i) {
    z ^= z >> 30;
    z *= 0xBF58476D1CE4E5B9U;
    z ^= z >> 27;
    z *= 0x94D049BB133111EBU;
    z ^= z >> 31;
  }
  return z >= 0x8000000000000000U;
}

double light_at(const RandomTarget& target, const Seen& seen, Vec2 at) {
  const double cell = target.cell_px, corner = -kCells / 2 * cell;
  double light = 0;
  const auto first_row = std::llround(std::floor((at.y - 5 - corner) / cell));
  const auto first_col = std::llround(std::floor((at.x - 5 - corner) / cell));
  const auto n = std::llround(10 / cell) + 1;
  std::vector<double> across;
  for (std::int64_t i = 0; i <= n; ++i) {
    const double from = corner + static_cast<double>(first_col + i) * cell;
    across.push_back(share(from, from + cell, at.x, seen.sigma_x * seen.scale));
  }
  for (std::int64_t j = 0; j <= n; ++j) {
    const double from = corner + static_cast<double>(first_row + j) * cell;
    const double wy = share(from, from + cell, at.y, seen.sigma_y * seen.scale);
    if (wy < 1e-13) continue;
    for (std::int64_t i = 0; i <= n; ++i) {
      if (is_clear(target.seed, first_col + i, first_row + j)) {
        light += wy * across[static_cast<std::size_t>(i)];
      }
    }
  }
  return light;
}

std::vector<float> picture(const RandomTarget& target, int side, const Seen& seen) {
  std::mt19937 random(seen.seed);
  std::normal_distribution<double> normal;
  std::vector<float> out;
  const double half = (side - 1) / 2.0;
  const Mat2 to_target = seen.target_from_scan();
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const double bow = seen.bow_px * std::pow((y - half) / half, 2);
      const Vec2 at = seen.middle + to_target * Vec2{x - half + bow, y - half};
      double light = (1 - seen.ghost) * light_at(target, seen, at);
      if (seen.ghost > 0) light += seen.ghost * light_at(target, seen, at - kGhost);
      const double lit = light * (1 + seen.light_x * (x - half) / half);
      out.push_back(static_cast<float>(0.1 + 0.6 * (lit + seen.noise * normal(random))));
    }
  }
  return out;
}

double gaussian(const Seen& seen, double dx, double dy) {
  return std::exp(-dx * dx / (2 * seen.sigma_x * seen.sigma_x) -
                  dy * dy / (2 * seen.sigma_y * seen.sigma_y)) /
         (2 * std::numbers::pi * seen.sigma_x * seen.sigma_y);
}

// Of all samples together, against the truth about the place that was found.
double error_of(const RandomPsf& psf, const Seen& seen) {
  const Vec2 off = seen.ghost > 0 ? seen.middle - psf.origin_px : Vec2{0, 0};
  double squares = 0, all = 0;
  for (int y = 0; y < psf.side; ++y) {
    for (int x = 0; x < psf.side; ++x) {
      const double dx = (x - psf.side / 2) * psf.step_px + off.x;
      const double dy = (y - psf.side / 2) * psf.step_px + off.y;
      const double truth = (1 - seen.ghost) * gaussian(seen, dx, dy) +
                           seen.ghost * gaussian(seen, dx - kGhost.x, dy - kGhost.y);
      squares += std::pow(psf.psf[static_cast<std::size_t>(y * psf.side + x)] - truth, 2);
      all += truth * truth;
    }
  }
  return std::sqrt(squares / all);
}

RandomPsf measure(const RandomTarget& target, int side, const Seen& seen,
                  RandomOptions options = {}) {
  const std::vector<float> samples = picture(target, side, seen);
  return measure_random(Span2D<const float>(samples.data(), side, side), RandomCells(target),
                        options);
}

void expect_transfer(const RandomPsf& psf, const Seen& seen, double within_sd) {
  for (const double f : {0.1, 0.2, 0.3, 0.4}) {
    const double t = 2 * std::pow(std::numbers::pi * f, 2);
    const RandomPsf::Point along = psf.mtf(f, 0), across = psf.mtf(0, f);
    EXPECT_NEAR(along.value, std::exp(-t * seen.sigma_x * seen.sigma_x),
                within_sd * along.sd + 5e-4)
        << f;
    EXPECT_NEAR(across.value, std::exp(-t * seen.sigma_y * seen.sigma_y),
                within_sd * across.sd + 5e-4)
        << f;
    EXPECT_LT(along.sd, 0.02);
  }
}

TEST(RandomTarget, FindsPlaceAndTransferWithDeviations) {
  const RandomTarget target{11, 0.5, kCells};
  Seen seen;
  seen.sigma_y = 0.9;
  seen.scale = 1.002;
  seen.light_x = 0.1;
  seen.bow_px = 0.2;
  const RandomPsf psf = measure(target, 96, seen);
  ASSERT_TRUE(psf.ok()) << sentence(psf.status);
  std::printf("place off by %.4f %.4f px (sd %.4f %.4f), sd of all %.2f %%, bend %.3f\n",
              psf.origin_px.x - seen.middle.x, psf.origin_px.y - seen.middle.y, psf.origin_sd_px.x,
              psf.origin_sd_px.y, 100 * psf.relative_sd, psf.bend_px);
  EXPECT_NEAR(psf.origin_px.x, seen.middle.x, 0.01);
  EXPECT_NEAR(psf.origin_px.y, seen.middle.y, 0.01);
  EXPECT_LT(psf.origin_sd_px.x, 0.01);
  EXPECT_NEAR(psf.scale.a, seen.scale, 1e-4);
  EXPECT_NEAR(psf.scale.d, seen.scale, 1e-4);
  EXPECT_NEAR(psf.bend_px, seen.bow_px, 0.02);
  EXPECT_NEAR(psf.noise, seen.noise, 0.05 * seen.noise);
  expect_transfer(psf, seen, 3.5);
}

// The spread is told along the scan's axes, however the target lies.
TEST(RandomTarget, TakesTargetsAsTheyAreLaidIn) {
  const RandomTarget target{4, 0.55, kCells};
  Seen seen;
  seen.turn_deg = 4.4;
  seen.noise = 0.004;
  RandomOptions options;
  options.support_px = 7;
  for (const bool mirrored : {false, true}) {
    seen.mirrored = mirrored;
    const RandomPsf psf = measure(target, 96, seen, options);
    ASSERT_TRUE(psf.ok()) << sentence(psf.status);
    EXPECT_EQ(psf.mirrored, mirrored);
    EXPECT_NEAR(psf.origin_px.x, seen.middle.x, 0.01);
    EXPECT_NEAR(psf.origin_px.y, seen.middle.y, 0.01);
    EXPECT_LT(error_of(psf, seen), 1.5 * psf.relative_sd);
    expect_transfer(psf, seen, 3.5);
  }
}

// 96 x 96 px, spread 7 x 7 px, 1 % noise: the error is the one that is claimed, and that of a
// registration known beforehand is hardly smaller.
TEST(RandomTarget, TheSpreadIsAsCloseAsItSays) {
  const RandomTarget target{5, 0.5, kCells};
  RandomOptions options;
  options.support_px = 7;
  double squares = 0, claimed = 0, place = 0, place_sd = 0;
  constexpr int kPictures = 3;
  for (unsigned i = 1; i <= kPictures; ++i) {
    Seen seen;
    seen.middle = {3.1 * i - 12.0, 7.3 * i - 31};
    seen.seed = i;
    const RandomPsf psf = measure(target, 96, seen, options);
    ASSERT_TRUE(psf.ok()) << sentence(psf.status);
    squares += std::pow(error_of(psf, seen), 2);
    claimed += psf.relative_sd * psf.relative_sd;
    place +=
        std::pow(psf.origin_px.x - seen.middle.x, 2) + std::pow(psf.origin_px.y - seen.middle.y, 2);
    place_sd += std::pow(psf.origin_sd_px.x, 2) + std::pow(psf.origin_sd_px.y, 2);
  }
  const double error = std::sqrt(squares / kPictures), sd = std::sqrt(claimed / kPictures);
  std::printf(
      "2-D spread, 96 x 96 px, noise 1 %%: error %.2f %%, claimed %.2f %%; place %.4f px, "
      "claimed %.4f px\n",
      100 * error, 100 * sd, std::sqrt(place / (2 * kPictures)),
      std::sqrt(place_sd / (2 * kPictures)));
  EXPECT_LT(error, 0.019);
  EXPECT_LT(error, 1.2 * sd);
  EXPECT_GT(error, 0.8 * sd);
  EXPECT_LT(place, 2.2 * place_sd);
  EXPECT_GT(place, 0.25 * place_sd);
}

// A spread that leans to one side, which no edge and no even function would show.
TEST(RandomTarget, FindsASpreadThatIsNotEven) {
  const RandomTarget target{8, 0.52, kCells};
  Seen seen;
  seen.ghost = 0.25;
  RandomOptions options;
  options.support_px = 7;
  const RandomPsf psf = measure(target, 96, seen, options);
  ASSERT_TRUE(psf.ok()) << sentence(psf.status);
  std::printf("leaning spread: error %.2f %%, claimed %.2f %%\n", 100 * error_of(psf, seen),
              100 * psf.relative_sd);
  EXPECT_LT(error_of(psf, seen), 1.3 * psf.relative_sd);
  // Far from what a Gaussian of the same width is.
  Seen even = seen;
  even.ghost = 0;
  EXPECT_GT(error_of(psf, even), 8 * psf.relative_sd);
}

TEST(RandomTarget, SaysWhatCannotBeTold) {
  // Cells as large as pixels, in step with them.
  Seen seen;
  seen.middle = {0.5, 0.5};
  EXPECT_EQ(measure({3, 1.0, kCells}, 65, seen).status, RandomStatus::kNotTold);
  // Another target, nothing at all, too small, clipped.
  const std::vector<float> other = picture({77, 0.5, kCells}, 64, {});
  const Span2D<const float> span(other.data(), 64, 64);
  const RandomCells cells({3, 0.5, kCells});
  EXPECT_EQ(measure_random(span, cells).status, RandomStatus::kOtherTarget);
  EXPECT_EQ(measure_random({other.data(), 20, 20, 64}, cells).status, RandomStatus::kTooSmall);
  RandomOptions low;
  low.highest = 0.4;
  EXPECT_EQ(measure_random(span, cells, low).status, RandomStatus::kNoSamples);
  std::vector<float> nothing(64 * 64, 0.5F);
  const Span2D<const float> grey(nothing.data(), 64, 64);
  EXPECT_EQ(measure_random(grey, cells).status, RandomStatus::kNoContrast);
  std::mt19937 random(1);
  std::normal_distribution<float> normal(0.5F, 0.1F);
  for (float& v : nothing) v = normal(random);
  EXPECT_EQ(measure_random(grey, cells).status, RandomStatus::kOtherTarget);
  nothing.assign(nothing.size(), std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(measure_random(grey, cells).status, RandomStatus::kNoSamples);
}

}  // namespace
}  // namespace reseau
