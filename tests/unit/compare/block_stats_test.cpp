// Noise, shift and bias of pictures made of known ones.
#include "capture/compare/block_stats.h"

#include <cmath>
#include <functional>
#include <random>

#include <gtest/gtest.h>

namespace reseau::compare {
namespace {

constexpr std::size_t kSide = 160;

using Field = std::function<double(double x, double y, std::size_t k)>;

std::vector<float> lab(const Field& field, double noise = 0, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<float> values;
  for (std::size_t y = 0; y < kSide; ++y) {
    for (std::size_t x = 0; x < kSide; ++x) {
      for (std::size_t k = 0; k < 3; ++k) {
        values.push_back(static_cast<float>(
            field(static_cast<double>(x), static_cast<double>(y), k) + noise * normal(random)));
      }
    }
  }
  return values;
}

std::vector<Block> blocks(const std::vector<float>& a, const std::vector<float>& b) {
  std::vector<Block> result;
  for (std::size_t y = 0; y < kSide; y += kBlockPx) {
    for (std::size_t x = 0; x < kSide; x += kBlockPx) {
      const auto from = [y](const std::vector<float>& v) {
        return std::span(v).subspan(3 * y * kSide);
      };
      result.push_back(measure_block(from(a), from(b), kSide, x));
    }
  }
  return result;
}

double slope(double x, double y, std::size_t k) { return k == 0 ? 40 + 0.1 * x : 5 - 0.05 * y; }
double detail(double x, double y, std::size_t k) {
  return k != 0 ? 0
                : 50 + 10 * std::sin(0.31 * x + 0.1) * std::cos(0.23 * y) +
                      5 * std::sin(0.2 * (x + y));
}

TEST(Noise, IsTheStandardDeviationAboutASlope) {
  const NoiseFigures noise = noise_of(blocks(lab(slope, 0.5, 1), lab(slope, 1.5, 2)));
  EXPECT_EQ(noise.n_blocks, 10);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(noise.a[k], 0.5, 0.06);
    EXPECT_NEAR(noise.b[k], 1.5, 0.18);
    ASSERT_TRUE(noise.ratio[k].has_value());
    EXPECT_NEAR(*noise.ratio[k], 3, 0.45);
  }
}

TEST(Noise, HasNoRatioAgainstNone) {
  const NoiseFigures noise = noise_of(blocks(lab(slope), lab(slope, 1)));
  EXPECT_LT(noise.a[0], 1e-3);
  EXPECT_FALSE(noise.ratio[1].has_value());
  EXPECT_EQ(noise_of({}).n_blocks, 0);
  const auto black = lab([](double, double, std::size_t) { return 0.0; });
  EXPECT_EQ(noise_of(blocks(black, black)).n_blocks, 0);
}

TEST(Shift, OfHalfAPixelIsSeenAndOfNoneIsNot) {
  const auto a = lab(detail, 0.05, 1);
  for (const auto& [dx, dy] : {std::pair{0.5, -0.3}, {0.0, 0.0}, {-0.2, 0.5}}) {
    const auto b = lab(
        [dx = dx, dy = dy](double x, double y, std::size_t k) { return detail(x - dx, y - dy, k); },
        0.05, 2);
    const ShiftFigures shift = shift_of(blocks(a, b));
    ASSERT_TRUE(shift.measured);
    EXPECT_NEAR(shift.x_px, dx, 0.02) << dx;
    EXPECT_NEAR(shift.y_px, dy, 0.02) << dy;
    EXPECT_LT(shift.sd_x_px, 0.02);
  }
}

TEST(Shift, NeedsDetailInBothDirections) {
  const auto stripes = lab([](double x, double, std::size_t) { return 50 + 10 * std::sin(x); });
  EXPECT_FALSE(shift_of(blocks(stripes, stripes)).measured);
  const auto flat = lab([](double, double, std::size_t) { return 50.0; });
  EXPECT_FALSE(shift_of(blocks(flat, flat)).measured);
}

TEST(Bias, IsTheMeanDifferenceWithItsError) {
  const auto a = lab(slope, 1, 1),
             b = lab([](double x, double y,
                        std::size_t k) { return slope(x, y, k) + (k == 1 ? 0.2 : 0); },
                     1, 2);
  const BiasFigures bias = bias_of(blocks(a, b));
  EXPECT_NEAR(bias.lab[1], 0.2, 4 * bias.sd[1]);
  EXPECT_GT(bias.lab[1], 6 * bias.sd[1]);
  EXPECT_NEAR(bias.lab[0], 0, 4 * bias.sd[0]);
  // One sample in a thousand pixels: the error of a mean.
  EXPECT_NEAR(bias.sd[0], std::sqrt(2.0) / kSide, 0.3 * std::sqrt(2.0) / kSide);
}

TEST(Blocks, WithAPixelThatIsNotFiniteAreLeftOut) {
  auto a = lab(slope);
  a[3 * (20 * kSide + 20)] = NAN;
  const auto all = blocks(a, a);
  int unusable = 0;
  for (const Block& block : all) unusable += block.usable ? 0 : 1;
  EXPECT_EQ(unusable, 1);
}

}  // namespace
}  // namespace reseau::compare
