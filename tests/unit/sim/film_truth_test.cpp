#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "drivers/sim/simulate.h"

namespace reseau::sim {
namespace {

// Mean of one channel over the inside of a patch, as a fraction of full scale.
double patch_mean(const SimulatedScan& scan, const Patch& patch, int channel, double margin_px) {
  double sum = 0;
  int n = 0;
  const int width = scan.format.width_px;
  for (int y = 0; y < scan.format.n_lines; ++y) {
    for (int x = 0; x < width; ++x) {
      if (x < patch.x0 + margin_px || x > patch.x1 - margin_px || y < patch.y0 + margin_px ||
          y > patch.y1 - margin_px) {
        continue;
      }
      sum += scan.samples[static_cast<std::size_t>((y * 4 + channel) * width + x)];
      ++n;
    }
  }
  return n == 0 ? NAN : sum / n / 65535;
}

TEST(FilmTruth, MeanOfAPatchIsTheAreaWeightedMixtureOfItsElements) {
  const SimSpec spec =
      parse_sim_spec("sim:ls5000?width_px=1200&height_px=1000&noise=0.002&level=0.9");
  const SimulatedScan scan = simulate_frame(spec);
  const std::array<double, 3> area = scan.truth.area_fractions();
  EXPECT_NEAR(area[0], 0.4208, 5e-5);
  EXPECT_NEAR(area[1], 0.2651, 5e-5);
  EXPECT_NEAR(area[2], 0.3141, 5e-5);
  const ElementResponse response = element_response(0);
  const std::vector<Patch> patches = scan.truth.patches();
  ASSERT_EQ(patches.size(), 24U);
  for (const Patch& patch : patches) {
    for (int c = 0; c < 4; ++c) {
      double expected = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        const double seen = c == 3 ? 1.0 : response[k][static_cast<std::size_t>(c)];
        expected += 0.9 * area[k] * patch.rgb[k] * seen;
      }
      // The window holds no whole number of periods: about one element row in twenty is cut.
      EXPECT_NEAR(patch_mean(scan, patch, c, 3), expected, 0.02 * expected + 1e-4)
          << "channel " << c << " at " << patch.x0 << ", " << patch.y0;
    }
    const auto truth = scan.truth.process_rgb((patch.x0 + patch.x1) / 2, (patch.y0 + patch.y1) / 2);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(truth[k], patch.rgb[k], 1e-6);
  }
}

TEST(FilmTruth, ScreenRepeatsAlongItsLatticeVectors) {
  const SimSpec spec =
      parse_sim_spec("ls5000?angle=23&axes=88.9&period_u_um=49.58&period_v_um=48.9");
  const FilmTruth truth(spec.film, {.width_px = 100, .n_lines = 100});
  const double degree = std::acos(-1.0) / 180;
  const double pu = 49.58 / 6.35, pv = 48.9 / 6.35;
  const ScreenPoint a = truth.screen_from_scan(10, 20);
  const ScreenPoint b =
      truth.screen_from_scan(10 + pu * std::sin(23 * degree), 20 + pu * std::cos(23 * degree));
  EXPECT_NEAR(b.u - a.u, 1, 1e-12);
  EXPECT_NEAR(b.v - a.v, 0, 1e-12);
  const double across = (23 - 88.9) * degree;
  const ScreenPoint c =
      truth.screen_from_scan(10 + pv * std::sin(across), 20 + pv * std::cos(across));
  EXPECT_NEAR(c.u - a.u, 0, 1e-12);
  EXPECT_NEAR(c.v - a.v, 1, 1e-12);
}

}  // namespace
}  // namespace reseau::sim
