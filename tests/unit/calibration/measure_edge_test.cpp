// Edges whose transfer is known exactly, and regions that hold none.
#include "calibration/edge/measure_edge.h"

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/edge_renderer.h"

namespace reseau {
namespace {

using test::EdgePicture;

Span2D<const float> span(const std::vector<float>& samples, int width, int height) {
  return {samples.data(), width, height};
}

EdgeMeasurement measure(const EdgePicture& p, const test::Transfer2D& transfer) {
  const std::vector<float> samples = render(p, transfer);
  EdgeOptions options;
  if (p.bits > 0) options.quantum = 1 / (std::pow(2.0, p.bits) - 1);
  return measure_edge(span(samples, p.width_px, p.height_px), options);
}

EdgePicture usual(double normal_deg) {
  EdgePicture p;
  p.normal_deg = normal_deg;
  set_usual_region(p, 100);
  return p;
}

double error_of(const EdgePicture& p, const test::Transfer2D& t) {
  const EdgeMeasurement m = measure(p, t);
  if (m.status == EdgeStatus::kRefused || !m.mtf.all.mtf50) return 1;
  return m.mtf.all.mtf50->f_cy_per_px / true_crossing(p, t, 0.5) - 1;
}

TEST(MeasureEdge, GaussianWithoutNoise) {
  for (const double angle : {1.0, 26.565, 44.5, 187.0, -80.0}) {
    for (const double mtf50 : {0.08, 0.4}) {
      const EdgePicture p = usual(angle);
      const test::Transfer2D t = test::gaussian_transfer(mtf50);
      const EdgeMeasurement m = measure(p, t);
      SCOPED_TRACE(testing::Message() << angle << " degrees, MTF50 " << mtf50);
      ASSERT_NE(m.status, EdgeStatus::kRefused);
      EXPECT_NEAR(m.mtf.all.mtf50->f_cy_per_px / mtf50, 1, 5e-4);
      for (const int k : {10, 20, 30, 40}) {
        const MtfPoint& point = m.mtf.all.points[static_cast<std::size_t>(k)];
        EXPECT_NEAR(point.value, true_transfer(p, t, point.f_cy_per_px), 3e-4) << k;
      }
      EXPECT_NEAR(std::remainder(m.normal_deg - angle, 360.0), 0, 1e-3);
    }
  }
}

TEST(MeasureEdge, LensDefocusSmearAndHaloWithoutNoise) {
  const test::Transfer2D lens = test::airy_box_transfer(8);
  const test::Transfer2D all[] = {lens, test::airy_box_transfer(8, 0.6), test::smeared(lens, 2),
                                  test::with_halo(lens, 0.1, 6)};
  for (const test::Transfer2D& t : all) {
    for (const double angle : {5.0, 36.87}) {
      EXPECT_NEAR(error_of(usual(angle), t), 0, 1.5e-3)
          << "transfer " << &t - all << " at " << angle;
    }
  }
}

TEST(EdgeSweep, NoiseStaysNearTheLimit) {
  const test::Transfer2D t = test::gaussian_transfer(0.25);
  double sum = 0, squares = 0, claimed = 0;
  constexpr int kEdges = 30;
  for (int i = 0; i < kEdges; ++i) {
    EdgePicture p = usual(2 + 1.3 * i);
    p.noise = 0.005;
    p.seed = static_cast<std::uint32_t>(100 + i);
    const EdgeMeasurement m = measure(p, t);
    ASSERT_EQ(m.status, EdgeStatus::kOk);
    const double e = m.mtf.all.mtf50->f_cy_per_px / 0.25 - 1;
    sum += e;
    squares += e * e;
    claimed += m.mtf.all.mtf50->sd / 0.25;
  }
  // Limit of two free parameters: 0.165 %. Thirty edges know their own scatter to 13 %.
  EXPECT_LT(std::sqrt(squares / kEdges), 1.15 * 0.00165 * 1.35);
  EXPECT_LT(std::abs(sum / kEdges), 0.001);
  EXPECT_NEAR(claimed / kEdges, 0.00165, 0.0004);
}

TEST(MeasureEdge, TurnedAndMirroredPicturesAgree) {
  EdgePicture p = usual(7);
  p.noise = 0.01;
  const test::Transfer2D t = test::airy_box_transfer(8);
  const std::vector<float> samples = render(p, t);
  const auto w = static_cast<std::size_t>(p.width_px), h = static_cast<std::size_t>(p.height_px);
  const double plain =
      measure_edge(span(samples, p.width_px, p.height_px)).mtf.all.mtf50->f_cy_per_px;
  std::vector<float> mirrored(samples.size()), transposed(samples.size()), negative(samples.size());
  for (std::size_t y = 0; y < h; ++y) {
    for (std::size_t x = 0; x < w; ++x) {
      const float v = samples[y * w + x];
      mirrored[y * w + (w - 1 - x)] = v;
      transposed[x * h + y] = v;
      negative[y * w + x] = 1 - v;
    }
  }
  EXPECT_NEAR(measure_edge(span(mirrored, p.width_px, p.height_px)).mtf.all.mtf50->f_cy_per_px,
              plain, 1e-5);
  EXPECT_NEAR(measure_edge(span(transposed, p.height_px, p.width_px)).mtf.all.mtf50->f_cy_per_px,
              plain, 1e-5);
  EXPECT_NEAR(measure_edge(span(negative, p.width_px, p.height_px)).mtf.all.mtf50->f_cy_per_px,
              plain, 1e-5);
}

TEST(MeasureEdge, NuisancesAreFitted) {
  const test::Transfer2D t = test::gaussian_transfer(0.25);
  EdgePicture across = usual(5);
  across.shade_across = 0.1;
  EXPECT_NEAR(error_of(across, t), 0, 3e-3);
  EdgePicture along = usual(5);
  along.dark = 0.1;
  along.bright = 0.6;
  along.shade_along = 0.25;
  EXPECT_NEAR(error_of(along, t), 0, 6e-3);
  EdgePicture bow = usual(5);
  bow.bow_px = 4;
  EXPECT_NEAR(error_of(bow, t), 0, 2.5e-3);
  EdgePicture dust = usual(5);
  dust.noise = 0.005;
  dust.dust_spots = 8;
  EXPECT_NEAR(error_of(dust, t), 0, 1e-2);
  EdgePicture hot = usual(5);
  hot.noise = 0.005;
  hot.hot_share = 0.005;
  EXPECT_NEAR(error_of(hot, t), 0, 6e-3);
}

TEST(MeasureEdge, ClippedSidesAreRefused) {
  for (const double noise : {0.0, 0.005}) {
    EdgePicture p = usual(6);
    p.bright = 0.9;
    p.noise = noise;
    p.clip_high = 0.02;
    const EdgeMeasurement m = measure(p, test::gaussian_transfer(0.25));
    EXPECT_EQ(m.status, EdgeStatus::kRefused) << noise;
    EXPECT_TRUE(m.has(EdgeReason::kClipped)) << noise;
  }
}

TEST(MeasureEdge, AlongTheGridThereIsAWordOfDoubt) {
  for (const double angle : {0.0, 45.0}) {
    const EdgePicture p = usual(angle);
    const EdgeMeasurement m = measure(p, test::gaussian_transfer(0.25));
    EXPECT_NE(m.status, EdgeStatus::kOk) << angle;
    EXPECT_FALSE(m.reasons.empty()) << angle;
    if (m.mtf.all.mtf50) {
      EXPECT_NEAR(m.mtf.all.mtf50->f_cy_per_px / 0.25, 1, 3e-3);
    }
  }
}

TEST(MeasureEdge, SmallRegions) {
  for (const int size : {12, 16}) {
    EdgePicture p;
    p.width_px = p.height_px = size;
    p.noise = 0.005;
    const EdgeMeasurement m = measure(p, test::gaussian_transfer(0.25));
    ASSERT_NE(m.status, EdgeStatus::kRefused) << size;
    EXPECT_NEAR(m.mtf.all.mtf50->f_cy_per_px / 0.25, 1, 4 * (size == 12 ? 0.012 : 0.006));
  }
}

void expect_refused(const std::vector<float>& samples, int w, int h, const char* what) {
  const EdgeMeasurement m = measure_edge(span(samples, w, h));
  EXPECT_EQ(m.status, EdgeStatus::kRefused) << what;
  EXPECT_FALSE(m.reasons.empty()) << what;
  EXPECT_TRUE(m.mtf.all.points.empty()) << what;
}

TEST(MeasureEdge, WhatIsNoEdgeIsRefusedWithAReason) {
  for (int size = 0; size <= 9; ++size) {
    expect_refused(std::vector<float>(static_cast<std::size_t>(size * size), 0.5F), size, size,
                   "too small");
  }
  expect_refused(std::vector<float>(6400, 0.5F), 80, 80, "constant");
  expect_refused(std::vector<float>(6400, std::nanf("")), 80, 80, "no numbers");
  std::mt19937 random(5);
  std::normal_distribution<float> normal;
  std::vector<float> samples(6400);
  for (int i = 0; i < 20; ++i) {
    for (float& v : samples) v = 0.5F + 0.05F * normal(random);
    expect_refused(samples, 80, 80, "noise");
  }
  const auto picture = [&](auto value) {
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double x = double(i % 80), y = double(i / 80);
      samples[i] = static_cast<float>(value(x, y)) + 0.003F * normal(random);
    }
    return samples;
  };
  const auto step = [](double d) { return 0.5 * std::erfc(-d); };
  expect_refused(picture([&](double x, double y) {
                   return 0.2 + 0.6 * (step(x - 25 - 0.1 * y) - step(x - 55 - 0.1 * y));
                 }),
                 80, 80, "bar");
  expect_refused(picture([&](double x, double y) {
                   return 0.2 + 0.3 * (step(x - 25 - 0.1 * y) + step(x - 55 - 0.1 * y));
                 }),
                 80, 80, "two steps");
  expect_refused(picture([&](double x, double y) {
                   return 0.2 + 0.6 * step(20 - std::hypot(x - 40, y - 40));
                 }),
                 80, 80, "disc");
  expect_refused(
      picture([&](double x, double y) { return 0.2 + 0.6 * step(x - 40.3) * step(y - 39.2); }), 80,
      80, "corner");
  expect_refused(picture([&](double x, double) { return 0.5 + 0.3 * std::sin(x * 0.7); }), 80, 80,
                 "grating");
}

// A region so wide that the second edge lies beyond what the first is fitted to.
TEST(MeasureEdge, ASecondEdgeIsSeenHoweverFarItIs) {
  std::mt19937 random(1);
  std::normal_distribution<float> normal;
  constexpr int kWidth = 160, kHeight = 120;
  std::vector<float> samples(std::size_t{kWidth} * kHeight);
  const auto step = [](double d) { return 0.5 * std::erfc(-d); };
  for (const double apart : {30.0, 40.0, 50.0, 70.0, 100.0}) {
    for (const double second : {-1.0, 0.8}) {  // of a bar; of stairs
      for (std::size_t i = 0; i < samples.size(); ++i) {
        const double d = double(i % kWidth) - 80 + 0.09 * (double(i / kWidth) - 60);
        samples[i] =
            static_cast<float>(0.1 + 0.4 * (step(d + apart / 2) + second * step(d - apart / 2))) +
            0.003F * normal(random);
      }
      expect_refused(samples, kWidth, kHeight, "a second edge");
    }
  }
}

TEST(MeasureEdge, SamplesThatAreNoNumbersAreLeftOut) {
  const EdgePicture p = usual(5);
  std::vector<float> samples = render(p, test::gaussian_transfer(0.25));
  const auto w = static_cast<std::size_t>(p.width_px);
  samples[50 * w + 40] = std::nanf("");
  for (std::size_t y = 0; y < 100; ++y) samples[y * w + 30] = HUGE_VALF;
  const EdgeMeasurement m = measure_edge(span(samples, p.width_px, p.height_px));
  ASSERT_NE(m.status, EdgeStatus::kRefused);
  EXPECT_TRUE(m.has(EdgeReason::kLeftOut));
  EXPECT_NEAR(m.mtf.all.mtf50->f_cy_per_px / 0.25, 1, 1e-3);
}

// At 1 in 3 the pixels see few places of the profile, and no spline shows what the optics lack.
TEST(MeasureEdge, AHaloIsFoundWhereTheGridRepeats) {
  const test::Transfer2D t = test::with_halo(test::airy_box_transfer(8), 0.1, 6);
  for (const double angle : {18.43, 26.565, 36.87}) {
    EXPECT_NEAR(error_of(usual(angle), t), 0, 2.5e-3) << angle;
  }
}

// Two channels of one scan: another lens, other noise, 0.1 px apart. What is claimed of the
// distance is what it is off by, also where neighbours' noise goes together.
TEST(MeasureEdge, ChannelsLieWhereTheyAreSaidToLie) {
  const test::Transfer2D sharp = test::airy_box_transfer(8), soft = test::airy_box_transfer(14);
  for (const double correlation : {0.0, 0.5}) {
    double squares = 0, mean = 0;
    constexpr int kSeeds = 14;
    for (std::uint32_t seed = 1; seed <= kSeeds; ++seed) {
      EdgePicture p = usual(seed % 2 == 0 ? 5 : 95);
      p.noise = 0.005;
      p.noise_correlation = correlation;
      p.seed = 2 * seed;
      EdgeOptions options;
      options.with_profile = true;
      const std::vector<float> green = render(p, sharp);
      p.seed += 1;
      p.offset_px += 0.1;
      const std::vector<float> infrared = render(p, soft);
      const EdgeMeasurement a = measure_edge(span(green, p.width_px, p.height_px), options);
      const EdgeMeasurement b = measure_edge(span(infrared, p.width_px, p.height_px), options);
      const PlaceDifference apart = place_difference(a.places, b.places, a.line.normal_rad);
      ASSERT_GT(apart.variance, 0);
      const double scatter = std::max(1.0, apart.chi2 / apart.freedom);
      const double z = (apart.value - 0.1) / std::sqrt(apart.variance * scatter + apart.common);
      squares += z * z / kSeeds;
      mean += z / kSeeds;
    }
    std::printf("channels apart, noise's correlation %.1f: z %.2f rms, %.2f mean\n", correlation,
                std::sqrt(squares), mean);
    EXPECT_GT(std::sqrt(squares), 0.6);
    EXPECT_LT(std::sqrt(squares), 1.2);
    EXPECT_LT(std::abs(mean), 0.8);
  }
}

}  // namespace
}  // namespace reseau
