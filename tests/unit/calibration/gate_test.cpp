// Open frames whose truth is known: dark, pixels, noise, lines of the sensor, leakage.
#include "calibration/gate/gate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace reseau {
namespace {

struct Truth {
  double dark = 0.011, read = 4e-7, shot = 3e-6, shading = 0.1, pixels = 0.01, line = 0.004,
         leak = 0.02;
};

constexpr int kWidth = 700, kLines = 64;
constexpr double kFull_us = 1000;  // that reaches 0.8 of full scale

// Exposures of all channels in factors of kFull_us.
GateScan scan_of(const Truth& t, const std::array<double, 4>& factors, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::mt19937 fixed(99);
  GateScan out;
  out.width_px = kWidth;
  out.n_lines = kLines;
  out.sensor_lines = 2;
  for (std::size_t c = 0; c < 4; ++c) out.exposure_us[c] = kFull_us * factors[c];
  for (std::size_t c = 0; c < 4; ++c) {
    std::vector<double> gain;
    for (int x = 0; x < kWidth; ++x) {
      const double rho = 2.0 * x / (kWidth - 1) - 1;
      gain.push_back((1 - t.shading * rho * rho) * (1 + t.pixels * normal(fixed)));
    }
    // Some of the infrared shows in red.
    const double light = 0.8 * (factors[c] + (c == 0 ? t.leak * factors[3] : 0.0));
    for (int y = 0; y < kLines; ++y) {
      const double lamp = 1 + (y % 2 == 0 ? t.line : -t.line);
      for (int x = 0; x < kWidth; ++x) {
        const double level = light * lamp * gain[static_cast<std::size_t>(x)];
        const double sd = std::sqrt(t.read + t.shot * level);
        out.light[c].push_back(
            static_cast<float>(std::clamp(t.dark + level + sd * normal(random), 0.0, 1.0)));
      }
    }
  }
  return out;
}

std::vector<GateScan> series(const Truth& t) {
  std::vector<GateScan> scans;
  unsigned seed = 1;
  for (const double f : {1.0, 0.7, 0.5, 0.25, 0.12, 0.06}) {
    scans.push_back(scan_of(t, {f, f, f, f}, seed++));
  }
  scans.push_back(scan_of(t, {1, 1, 1, 0.3}, seed++));
  scans.push_back(scan_of(t, {0.3, 1, 1, 1}, seed++));
  scans.push_back(scan_of(t, {1, 0.3, 1, 1}, seed++));
  return scans;
}

// Within four of its own deviations, which must not be vast either.
void expect_close(const Measured& m, double truth, double most_sd, const char* what) {
  EXPECT_NEAR(m.value, truth, 4 * m.sd + 1e-12) << what;
  EXPECT_LT(m.sd, most_sd) << what;
  EXPECT_GT(m.sd, 0) << what;
}

TEST(Gate, FindsWhatTheUnitHas) {
  const Truth t;
  const GateResult result = measure_gate(series(t));
  EXPECT_TRUE(result.remarks.empty()) << result.remarks.front();
  for (std::size_t c = 0; c < 4; ++c) {
    const GateChannel& channel = result.channels[c];
    ASSERT_TRUE(channel.dark && channel.noise && channel.nonlinearity && channel.shading) << c;
    expect_close(*channel.dark, t.dark, 2e-4, "dark");
    const GateNoise& noise = *channel.noise;
    expect_close({noise.read, std::sqrt(noise.read_variance)}, t.read, 0.1 * t.read, "read");
    expect_close({noise.shot, std::sqrt(noise.shot_variance)}, t.shot, 0.05 * t.shot, "shot");
    EXPECT_LT(noise.covariance, 0);  // the two trade for each other
    ASSERT_EQ(channel.line_gains.size(), 2U);
    expect_close(channel.line_gains[0], 1 + t.line, 1e-3, "line gain");
    EXPECT_NEAR(*channel.pixel_rms, t.pixels, 0.1 * t.pixels);
    EXPECT_NEAR(*channel.shading, t.shading * (0.95 * 0.95 - 0.05 * 0.05), 0.01);
    EXPECT_LT(channel.nonlinearity->value, 2e-4);
    ASSERT_EQ(channel.flat_gain.size(), static_cast<std::size_t>(kWidth));
  }
  ASSERT_TRUE(result.channels[0].leakage[3] && result.channels[1].leakage[3]);
  expect_close(*result.channels[0].leakage[3], t.leak, 2e-3, "leak");
  expect_close(*result.channels[1].leakage[3], 0, 2e-3, "no leak");
}

// Deviations are honest: over many units, errors are as large as claimed.
TEST(Gate, DeviationsAreHonest) {
  const Truth t;
  double squares = 0;
  constexpr int kUnits = 16;
  for (int i = 0; i < kUnits; ++i) {
    std::vector<GateScan> scans;
    for (int k = 0; k < 4; ++k) {
      const double f = std::array{1.0, 0.5, 0.2, 0.05}[static_cast<std::size_t>(k)];
      scans.push_back(scan_of(t, {f, f, f, f}, static_cast<unsigned>(100 * i + k + 1)));
    }
    const GateResult result = measure_gate(scans);
    const GateNoise& noise = *result.channels[1].noise;
    const double z = (noise.shot - t.shot) / std::sqrt(noise.shot_variance);
    squares += z * z;
  }
  const double rms = std::sqrt(squares / kUnits);
  EXPECT_GT(rms, 0.5);
  EXPECT_LT(rms, 1.5);
}

TEST(Gate, FlatGainFlattens) {
  const Truth t;
  const GateResult result = measure_gate(series(t));
  const GateScan fresh = scan_of(t, {0.6, 0.6, 0.6, 0.6}, 77);
  const GateChannel& green = result.channels[1];
  double squares = 0;
  for (int x = 0; x < kWidth; ++x) {
    double sum = 0;
    for (int y = 0; y < kLines; ++y) {
      sum += static_cast<double>(
          fresh.light[1][static_cast<std::size_t>(y) * kWidth + static_cast<std::size_t>(x)]);
    }
    const double light =
        (sum / kLines - green.dark->value) * green.flat_gain[static_cast<std::size_t>(x)];
    squares += std::pow(light - 0.48 * (1 - t.shading / 3), 2);
  }
  EXPECT_LT(std::sqrt(squares / kWidth), 0.002);
}

TEST(Gate, SaysWhatOneScanCannotTell) {
  GateScan one = scan_of({}, {1, 1, 1, 1}, 3);
  one.exposure_us = {};
  one.sensor_lines = 0;
  const GateResult result = measure_gate({one});
  const GateChannel& red = result.channels[0];
  EXPECT_FALSE(red.dark || red.noise || red.nonlinearity);
  EXPECT_FALSE(red.flat_gain.empty());
  EXPECT_GE(result.remarks.size(), 8U);
}

TEST(Gate, TakesAnythingForSamples) {
  EXPECT_TRUE(measure_gate({}).channels[0].levels.empty());
  GateScan odd;
  EXPECT_TRUE(measure_gate({odd}).channels[0].levels.empty());
  odd.width_px = odd.n_lines = 1;
  odd.light[0] = {0.5F};
  odd.exposure_us[0] = 10;
  (void)measure_gate({odd, odd});
  odd.width_px = 4;
  odd.light[0].assign(4, std::numeric_limits<float>::quiet_NaN());
  (void)measure_gate({odd, odd, odd});
  GateScan white = scan_of({}, {1, 1, 1, 1}, 3);
  for (auto& plane : white.light) std::ranges::fill(plane, 1.0F);
  const GateResult clipped = measure_gate({white});
  EXPECT_TRUE(clipped.channels[2].levels.front().clipped);
  EXPECT_TRUE(clipped.channels[2].flat_gain.empty());
}

}  // namespace
}  // namespace reseau
