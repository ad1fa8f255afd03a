// From light to numbers.
#include "drivers/sim/sensor.h"

#include <array>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "drivers/sim/film.h"
#include "drivers/sim/sensor_curves.h"

namespace reseau::sim {
namespace {

constexpr int kWidth = 400, kLines = 24;

struct Moments {
  double mean = 0, variance = 0;
};

class Bench {
 public:
  explicit Bench(const SensorSpec& sensor) : sensor_(sensor) {
    pass_.level.fill(1);
    pass_.field_px = kWidth;
  }
  std::vector<std::uint16_t> expose(float light, std::uint64_t pass = 0) {
    pass_.pass = pass;
    const std::vector<float> even(kWidth * kLines * kChannels, light);
    std::vector<std::uint16_t> out(even.size());
    digitise(even, {.width_px = kWidth, .n_lines = kLines}, 0, sensor_, pass_, out);
    return out;
  }
  static double at(const std::vector<std::uint16_t>& values, int line, int channel, int x) {
    return values[static_cast<std::size_t>((line * kChannels + channel) * kWidth + x)] / 65535.0;
  }
  Moments moments(float light) {
    const std::vector<std::uint16_t> values = expose(light);
    Moments m;
    for (const std::uint16_t v : values) m.mean += v / 65535.0;
    m.mean /= static_cast<double>(values.size());
    for (const std::uint16_t v : values) m.variance += std::pow(v / 65535.0 - m.mean, 2);
    m.variance /= static_cast<double>(values.size());
    return m;
  }

 private:
  SensorSpec sensor_;
  SensorPass pass_;
};

TEST(Sensor, VarianceFollowsTheNoiseModel) {
  SensorSpec s;
  s.noise = 0.01;
  s.read_noise = 0.003;
  s.dark_noise = 0.002;
  s.dark_level = 0.05;
  const NoiseModel model = noise_model(s, 1);
  EXPECT_NEAR(model.variance(1), 1e-4 + 9e-6 + 4e-6, 1e-9);
  for (const float light : {0.05F, 0.3F, 0.8F}) {
    const Moments m = Bench(s).moments(light);
    EXPECT_NEAR(m.mean, light + 0.05, 2e-4);
    // 38400 samples: the relative error of a variance is 0.7 %.
    EXPECT_NEAR(m.variance / model.variance(light), 1, 0.03) << light;
  }
}

TEST(Sensor, ClipsAtBothEndsAndQuantises) {
  SensorSpec s;
  s.noise = 0;
  EXPECT_EQ(Bench(s).expose(1.2F)[0], 65535);
  EXPECT_EQ(Bench(s).expose(-0.1F)[0], 0);
  s.adc_bits = 10;
  EXPECT_EQ(Bench(s).expose(0.5F)[0], 512);
}

TEST(Sensor, ShadingFallsTowardsBothEndsOfTheField) {
  SensorSpec s;
  s.noise = 0;
  s.shading = 0.2;
  const auto v = Bench(s).expose(0.5F);
  EXPECT_NEAR(Bench::at(v, 0, 1, 200), 0.5, 1e-4);
  EXPECT_NEAR(Bench::at(v, 0, 1, 0), 0.5 * (1 - 0.2 * 0.9975 * 0.9975), 1e-4);
  EXPECT_NEAR(Bench::at(v, 3, 2, 0), Bench::at(v, 3, 2, 399), 2e-5);
}

TEST(Sensor, PatternsBelongToPixelsNotToLinesOrPasses) {
  SensorSpec s;
  s.noise = 0;
  s.pixel_gain = 0.02;
  s.dark_pattern = 0.004;
  s.dark_level = 0.05;
  Bench bench(s);
  const auto dark = bench.expose(0, 1), again = bench.expose(0, 2), lit = bench.expose(0.5F, 3);
  EXPECT_EQ(dark, again);
  double offset = 0, gain = 0;
  for (int x = 0; x < kWidth; ++x) {
    EXPECT_EQ(Bench::at(dark, 0, 0, x), Bench::at(dark, 17, 0, x));
    const double d = Bench::at(dark, 0, 0, x) - 0.05;
    const double g = (Bench::at(lit, 0, 0, x) - Bench::at(dark, 0, 0, x)) / 0.5 - 1;
    offset += d * d, gain += g * g;
  }
  EXPECT_NEAR(std::sqrt(offset / kWidth), 0.004, 0.0006);
  EXPECT_NEAR(std::sqrt(gain / kWidth), 0.02, 0.003);
  EXPECT_NE(Bench::at(dark, 0, 0, 5), Bench::at(dark, 0, 1, 5)) << "channels differ";
}

TEST(Sensor, LinesDifferByGainAndByTheRecordedCurves) {
  SensorSpec s;
  s.noise = 0;
  s.n_lines = 3;
  s.line_gap_px = 2;
  s.line_gain = 0.1;
  const auto v = Bench(s).expose(0.4F);
  const std::array<double, 6> expected{0.4, 0.4, 0.44, 0.44, 0.36, 0.36};
  for (int line = 0; line < 12; ++line) {
    EXPECT_NEAR(Bench::at(v, line, 3, 10), expected[static_cast<std::size_t>(line % 6)], 2e-5);
  }
  s.n_lines = 2;
  s.line_gap_px = 1;
  s.line_gain = 0;
  s.line_response = 1;
  // Point 10 of red, type 1: 0x3252 in the first line is 0x322a... as recorded.
  const auto point = [](int line, int k) {
    const std::string_view hex = recorded_curves(0);
    const auto at = static_cast<std::size_t>(4 * ((2 * line + 1) * kCurvePoints + k));
    return std::stoi(std::string(hex.substr(at, 4)), nullptr, 16) / 65535.0;
  };
  for (const int k : {2, 7, 10, 15}) {
    const double first = point(0, k), second = point(1, k);
    ASSERT_NE(first, second);
    const auto w = Bench(s).expose(static_cast<float>(first));
    EXPECT_NEAR(Bench::at(w, 0, 0, 3), first, 2e-5);
    EXPECT_NEAR(Bench::at(w, 1, 0, 3), second, 3e-5) << k;
  }
  EXPECT_EQ(LineResponse(0, 1, 1)(0.0005F), 0.0005F) << "unchanged below the first point";
  EXPECT_EQ(LineResponse(0, 0, 1)(0.3F), 0.3F);
}

}  // namespace
}  // namespace reseau::sim
