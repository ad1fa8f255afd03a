// Where edges are sought in a frame: the one that stands alone is found, what only looks like one
// within a region is not.
#include "calibration/edge/find_edges.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

namespace reseau {
namespace {

constexpr int kWidth = 520, kHeight = 520;

// Light at (x, y) for every pixel, with the same small noise in every run.
template <typename Light>
std::vector<float> picture(Light light) {
  std::vector<float> samples;
  std::uint32_t state = 1;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      state = state * 1664525u + 1013904223u;
      const double noise = (static_cast<double>(state >> 8) / (1 << 24) - 0.5) * 0.01;
      samples.push_back(static_cast<float>(light(x, y) + noise));
    }
  }
  return samples;
}

double soft_step(double d_px) { return 0.2 + 0.3 * std::erfc(-d_px / 1.5); }

std::vector<EdgePlace> found_in(const std::vector<float>& samples) {
  return find_edges({samples.data(), kWidth, kHeight}, 5);
}

TEST(FindEdges, AlongOneEdgeRegionsThatHoldItInTheMiddle) {
  const double angle = 5 * std::numbers::pi / 180;
  const auto places = found_in(picture([&](int x, int y) {
    return soft_step((x - 260) * std::cos(angle) + (y - 260) * std::sin(angle));
  }));
  ASSERT_GE(places.size(), 3U);
  for (const EdgePlace& p : places) {
    const double edge_x = 260 - (p.y + p.height / 2.0 - 260) * std::tan(angle);
    EXPECT_NEAR(p.x + p.width / 2.0, edge_x, 0.25 * p.width);
  }
}

TEST(FindEdges, EverySideOfASlantedSquare) {
  const double angle = 8 * std::numbers::pi / 180;
  const auto places = found_in(picture([&](int x, int y) {
    const double u = (x - 260) * std::cos(angle) + (y - 260) * std::sin(angle);
    const double v = -(x - 260) * std::sin(angle) + (y - 260) * std::cos(angle);
    return soft_step(std::max(std::abs(u), std::abs(v)) - 110);
  }));
  EXPECT_GE(places.size(), 4U);
}

// The sides of a wedge are straight, but its neighbours' light lies on the flat areas: figures that
// differ by tens of per cent come of it.
TEST(FindEdges, NothingInASectorStar) {
  const auto places = found_in(picture([&](int x, int y) {
    const double r = std::hypot(x - 260, y - 260), a = std::atan2(y - 260, x - 260);
    return r < 180 && std::cos(4 * a) > 0 ? 0.2 : 0.8;
  }));
  EXPECT_TRUE(places.empty());
}

TEST(FindEdges, NothingInDiscsTextureAndFlatness) {
  EXPECT_TRUE(found_in(picture([](int x, int y) {
                return soft_step(std::hypot(x - 260, y - 260) - 60);
              })).empty());
  EXPECT_TRUE(found_in(picture([](int x, int y) {
                return 0.5 + 0.3 * std::sin(0.21 * x) * std::sin(0.17 * y);
              })).empty());
  EXPECT_TRUE(found_in(picture([](int, int) { return 0.5; })).empty());
}

}  // namespace
}  // namespace reseau
