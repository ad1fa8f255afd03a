// Real scans, where they are at hand.
#include <cmath>
#include <filesystem>
#include <vector>

#include <gtest/gtest.h>

#include "calibration/edge/find_edges.h"
#include "calibration/edge/measure_edge.h"
#include "tests/support/tiff_planes.h"

namespace reseau {
namespace {

using test::Planes;
using test::read_planes;

EdgeMeasurement measure(const Planes& planes, std::size_t channel) {
  return measure_edge({planes.samples[channel].data(), planes.width, planes.height},
                      {.lowest = 0, .highest = 1, .quantum = 1.0 / 65535});
}

std::filesystem::path scan(const char* name) {
  return std::filesystem::path(RESEAU_SHARED_DIR) / "data" / "scans" / name;
}

TEST(EdgeFiles, RazorOnACoolscan9000) {
  const auto path = scan("razor-ls9000-4000dpi-rgbi.tif");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not here";
  const Planes planes = read_planes(path);
  ASSERT_EQ(planes.samples.size(), 4U);
  // What five other programs agree on to one per cent.
  const double expected[] = {0.222, 0.244, 0.239, 0.218};
  double found[4] = {};
  for (std::size_t c = 0; c < 4; ++c) {
    const EdgeMeasurement m = measure(planes, c);
    SCOPED_TRACE(c);
    ASSERT_EQ(m.status, EdgeStatus::kOk);
    found[c] = m.mtf.all.mtf50->f_cy_per_px;
    EXPECT_NEAR(found[c] / expected[c], 1, 0.01);
    EXPECT_NEAR(m.mtf.window.mtf50->f_cy_per_px / expected[c], 1, 0.01);
    EXPECT_LT(m.mtf.all.points[50].value, 0.015);
    EXPECT_NEAR(m.angle_deg, 4.8, 0.15);
    EXPECT_NEAR(m.wander_px, 0.037, 0.01);
  }
  EXPECT_GT(found[1], found[2]);
  EXPECT_GT(found[2], found[0]);
  EXPECT_GT(found[0], found[3]);
}

TEST(EdgeFiles, CirclesAreNoEdge) {
  const auto path = scan("not-an-edge-phaseone-circles.tif");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not here";
  const Planes planes = read_planes(path);
  const EdgeMeasurement whole = measure(planes, 0);
  EXPECT_EQ(whole.status, EdgeStatus::kRefused);
  EXPECT_FALSE(whole.reasons.empty());
  const Span2D<const float> samples(planes.samples[0].data(), planes.width, planes.height);
  for (const EdgePlace& place : find_edges(samples, 5)) {
    const Span2D<const float> part(
        samples.data() + static_cast<std::ptrdiff_t>(place.y) * planes.width + place.x, place.width,
        place.height, planes.width);
    EXPECT_EQ(measure_edge(part, {}).status, EdgeStatus::kRefused) << place.x << "," << place.y;
  }
}

}  // namespace
}  // namespace reseau
