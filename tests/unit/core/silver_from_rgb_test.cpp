#include "core/reconstruct/silver_from_rgb.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "core/line/memory_line_source.h"
#include "core/line/rgb_lines.h"

namespace reseau {
namespace {

constexpr int kWidth = 120, kLines = 90;
// What the scanner sees behind each clear element, and the weights that make all three equal 1.
constexpr double kResponse[3][3] = {{1.2, 0.2, 0.15}, {0.1, 1.0, 0.4}, {0.1, 0.2, 0.8}};

// Silver behind random elements, a little noise, a dark level in the colours.
MemoryLineSource scan_of(double dark, double noise, bool infrared, double alike = 0) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> silver(0.02, 0.7);
  std::normal_distribution<double> grain(0, noise);
  LineFormat format;
  format.width_px = kWidth;
  format.n_lines = kLines;
  format.channels = {Channel::kRed, Channel::kGreen, Channel::kBlue};
  if (infrared) format.channels.push_back(Channel::kInfrared);
  std::vector<std::uint16_t> samples(format.samples_per_line() * kLines);
  for (std::size_t y = 0; y < kLines; ++y) {
    for (std::size_t x = 0; x < kWidth; ++x) {
      const double t = silver(random);
      const double* p = kResponse[random() % 3];
      std::uint16_t* line = samples.data() + y * format.samples_per_line();
      for (std::size_t c = 0; c < format.channels.size(); ++c) {
        double v = c == 3 ? t : dark + t * (alike + (1 - alike) * p[c]) + grain(random);
        v = std::clamp(v, 0.0, 1.0);
        line[c * kWidth + x] = static_cast<std::uint16_t>(std::lround(65535 * v));
      }
    }
  }
  return {format, std::move(samples)};
}

double against_element(const SilverWeights& silver, std::size_t element) {
  double sum = 0;
  for (std::size_t c = 0; c < 3; ++c) sum += silver.weights[c] * kResponse[element][c];
  return sum;
}

TEST(SilverFromRgb, FindsTheWeightsThatMakeTheElementsEqual) {
  const auto learned = learn_silver_from_rgb(scan_of(0.01, 0, true), ToneCurves::linear(), {});
  ASSERT_TRUE(learned.has_value());
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(against_element(learned->silver, k), 1, 1e-3) << k;
  }
  double dark = learned->silver.offset;
  for (const double w : learned->silver.weights) dark += 0.01 * w;
  EXPECT_NEAR(dark, 0, 1e-4);
  EXPECT_GT(learned->correlation, 0.99999);
  EXPECT_LT(learned->rms_relative, 1e-3);
  EXPECT_EQ(learned->n_pixels, static_cast<std::size_t>(kWidth * kLines));
}

TEST(SilverFromRgb, NoiseLowersTheCorrelationAndIsSaid) {
  const auto learned = learn_silver_from_rgb(scan_of(0, 0.03, true), ToneCurves::linear(), {});
  ASSERT_TRUE(learned.has_value());
  EXPECT_LT(learned->correlation, 0.999);
  EXPECT_GT(learned->correlation, 0.95);
  EXPECT_GT(learned->rms_relative, 0.03);
}

TEST(SilverFromRgb, NothingWithoutInfraredOrWithColoursAlike) {
  EXPECT_FALSE(learn_silver_from_rgb(scan_of(0, 0, false), ToneCurves::linear(), {}).has_value());
  EXPECT_FALSE(learn_silver_from_rgb(scan_of(0, 0, true, 1), ToneCurves::linear(), {}).has_value());
}

TEST(RgbLines, LeavesInfraredOut) {
  const MemoryLineSource whole = scan_of(0.01, 0, true);
  const RgbLines rgb(whole);
  ASSERT_EQ(rgb.format().n_channels(), 3);
  EXPECT_EQ(rgb.committed(), kLines);
  std::vector<std::uint16_t> four(std::size_t{4} * kWidth * 5), three(std::size_t{3} * kWidth * 5);
  whole.read(7, 5, four);
  rgb.read(7, 5, three);
  for (std::size_t y = 0; y < 5; ++y) {
    for (std::size_t i = 0; i < std::size_t{3} * kWidth; ++i) {
      ASSERT_EQ(three[y * 3 * kWidth + i], four[y * 4 * kWidth + i]);
    }
  }
}

}  // namespace
}  // namespace reseau
