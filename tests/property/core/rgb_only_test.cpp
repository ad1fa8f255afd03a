// A film whose silver is made of red, green and blue by the answers of its own elements: the same
// weights as infrared teaches, and the colours of the scene up to a white balance.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/line/memory_line_source.h"
#include "core/line/rgb_lines.h"
#include "core/reconstruct/reconstruct.h"
#include "core/reconstruct/silver_from_rgb.h"
#include "drivers/sim/simulate.h"
#include "tests/support/picture.h"

namespace reseau {
namespace {

constexpr int kSide = 800;
constexpr std::size_t kColumns = 6, kRows = 4;  // patches of the chart

class RgbOnlyFilm : public testing::TestWithParam<std::string> {};

TEST_P(RgbOnlyFilm, GivesTheWeightsOfInfraredAndTheColoursUpToAWhiteBalance) {
  const sim::SimSpec spec =
      sim::parse_sim_spec("ls5000?width_px=800&height_px=800&scene=chart24&" + GetParam());
  const sim::SimulatedScan scan = sim::simulate_frame(spec);
  const MemoryLineSource whole(scan.format, scan.samples);
  const RgbLines source(whole);
  const Registration registration = register_screen(source, {}, {}, {});
  ASSERT_TRUE(registration.found) << registration.reason;
  ReconstructOptions options;
  options.white_level = spec.sensor.clear_level;
  test::MemorySink sink;
  const ReconstructionReport report = reconstruct(source, registration, options, sink, {}, {});
  ASSERT_FALSE(report.from_infrared);

  const auto learned = learn_silver_from_rgb(whole, ToneCurves::linear(), {});
  ASSERT_TRUE(learned.has_value());
  // Infrared of clear film is the clear level; that of the brightest silver counts as 1.
  for (std::size_t c = 0; c < 3; ++c) {
    const double ratio =
        report.silver_from_rgb.weights[c] * spec.sensor.clear_level / learned->silver.weights[c];
    EXPECT_NEAR(ratio, 1, 0.15) << "channel " << c;
    fmt::print("{:.3f} ", ratio);
  }

  // Patches of 6 x 4: the middle of those whose scene is flat.
  std::vector<std::array<double, 3>> seen, true_rgb;
  constexpr int kHalf = 30;
  for (std::size_t j = 0; j < kRows; ++j) {
    for (std::size_t i = 0; i < kColumns; ++i) {
      const int x = static_cast<int>((static_cast<double>(i) + 0.5) * kSide / kColumns);
      const int y = static_cast<int>((static_cast<double>(j) + 0.5) * kSide / kRows);
      std::array<double, 3> mean{};
      double spread = 0;
      int n = 0;
      const auto middle = scan.truth.process_rgb(x, y);
      for (int b = -kHalf; b <= kHalf; b += 5) {
        for (int a = -kHalf; a <= kHalf; a += 5, ++n) {
          const auto value = scan.truth.process_rgb(x + a, y + b);
          for (std::size_t c = 0; c < 3; ++c) {
            mean[c] += value[c];
            spread = std::max(spread, std::abs(value[c] - middle[c]));
          }
        }
      }
      if (spread > 1e-3) continue;
      for (double& value : mean) value /= n;
      true_rgb.push_back(mean);
      seen.push_back(sink.mean(x - kHalf, y - kHalf, x + kHalf, y + kHalf));
    }
  }
  ASSERT_GE(seen.size(), 18U);
  // The balance of one grey: the brightest patch that is one.
  std::array<double, 3> factor{};
  double brightest = 0;
  for (std::size_t k = 0; k < seen.size(); ++k) {
    const auto [low, high] = std::minmax_element(true_rgb[k].begin(), true_rgb[k].end());
    if (*high > 1.02 * *low || *low < brightest) continue;
    brightest = *low;
    for (std::size_t c = 0; c < 3; ++c) factor[c] = true_rgb[k][c] / seen[k][c];
  }
  ASSERT_GT(brightest, 0.3);
  double sum = 0, largest = 0;
  for (std::size_t k = 0; k < seen.size(); ++k) {
    for (std::size_t c = 0; c < 3; ++c) seen[k][c] *= factor[c];
    const double e = test::process_delta_e(seen[k], true_rgb[k]);
    sum += e;
    largest = std::max(largest, e);
  }
  const double mean = sum / static_cast<double>(seen.size());
  fmt::print("{}: dE00 {:.3f} mean {:.3f} max of {}\n", GetParam(), mean, largest, seen.size());
  EXPECT_LT(mean, 0.5);
}

INSTANTIATE_TEST_SUITE_P(Films, RgbOnlyFilm,
                         testing::Values("angle=23&noise=0.002", "angle=67&blur_px=1.0&seed=5",
                                         "angle=-35&fade=0.3&seed=9&noise=0.003"));

}  // namespace
}  // namespace reseau
