#include "core/screen/map_uncertainty.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace reseau {
namespace {

// Windows of 0.01 periods on a grid; the map has a period of 8 px.
std::vector<PlacedInfo> windows(double end_x) {
  std::vector<PlacedInfo> samples;
  for (double y = 16; y < 800; y += 32) {
    for (double x = 16; x < end_x; x += 32) samples.push_back({{x, y}, 1e4, 1e4, 4e4, 4e4});
  }
  return samples;
}

const ScreenMap kMap({0.125, 0, 0, 0.125}, {});

TEST(MapUncertainty, AnAffineMapIsSurestInItsMiddle) {
  const MapUncertainty sure(kMap, windows(800), {}, 800, 800);
  const double middle = sure.at({400, 400}).sd().x, corner = sure.at({0, 0}).sd().x;
  // 625 windows of 0.08 px: 0.0032 px for their mean if they were independent.
  EXPECT_GT(middle, 0.0032);
  EXPECT_LT(middle, 0.006);
  EXPECT_NEAR(corner / middle, std::sqrt(7.0), 0.2);
  // Noise of half of that alone: half the error of a plane through independent windows.
  EXPECT_NEAR(sure.rms_px() / sure.bound_px(), 2 * std::sqrt(1.8), 0.1);
}

TEST(MapUncertainty, WhereSplinesHaveNoWindowsTheyMayBeOffByAllTheyDo) {
  MapErrorModel model;
  model.spacing_px = 64;
  model.amplitude_periods = 0.25;
  const MapUncertainty half(kMap, windows(400), model, 800, 800);
  EXPECT_LT(half.at({200, 400}).sd().x, 0.2);
  EXPECT_NEAR(half.at({780, 400}).sd().x, 2, 0.2);
}

TEST(MapUncertainty, ResidualsBeyondTheClaimMakeItLessSure) {
  MapErrorModel model;
  model.excess_u = 4;
  const MapUncertainty loose(kMap, windows(800), model, 800, 800),
      sure(kMap, windows(800), {}, 800, 800);
  EXPECT_NEAR(loose.at({100, 300}).sd().x / sure.at({100, 300}).sd().x, 2, 1e-6);
  EXPECT_NEAR(loose.at({100, 300}).sd().y / sure.at({100, 300}).sd().y, 1, 1e-6);
  EXPECT_EQ(MapUncertainty().at({1, 1}).xx, 0);
}

}  // namespace
}  // namespace reseau
