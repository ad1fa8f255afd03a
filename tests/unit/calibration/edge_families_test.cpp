// Long rows of edges: every claim of the uncertainty is held against the truth.
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "calibration/edge/measure_edge.h"
#include "tests/support/edge_renderer.h"

namespace reseau {
namespace {

TEST(EdgeFamilies, IntervalsCoverTheTruth) {
  const test::Transfer2D lens = test::airy_box_transfer(8);
  const test::Transfer2D families[] = {
      test::gaussian_transfer(0.25),       lens,
      test::airy_box_transfer(8, 0.5),     test::smeared(lens, 1.5),
      test::with_halo(lens, 0.1, 6),       test::sharpened(lens, 0.5, 1),
      test::exponential_transfer(0.5, 0.4)};
  int n = 0, covered = 0;
  double z2 = 0;
  std::uint32_t seed = 1;
  for (const test::Transfer2D& t : families) {
    for (int i = 0; i < 12; ++i) {
      test::EdgePicture p;
      p.normal_deg = 2.3 + 3.4 * i;
      p.noise = 0.01;
      p.noise_correlation = i % 3 == 0 ? 0.5 : 0;
      p.seed = ++seed;
      set_usual_region(p, 80);
      const std::vector<float> samples = render(p, t);
      const EdgeMeasurement m =
          measure_edge(Span2D<const float>(samples.data(), p.width_px, p.height_px));
      ASSERT_NE(m.status, EdgeStatus::kRefused) << &t - families << " " << p.normal_deg;
      const double z =
          (m.mtf.all.mtf50->f_cy_per_px - true_crossing(p, t, 0.5)) / m.mtf.all.mtf50->sd;
      ++n;
      covered += std::abs(z) < 1.96 ? 1 : 0;
      z2 += z * z;
    }
  }
  EXPECT_GE(covered, n * 88 / 100);
  EXPECT_GT(std::sqrt(z2 / n), 0.75);
  EXPECT_LT(std::sqrt(z2 / n), 1.35);
}

}  // namespace
}  // namespace reseau
