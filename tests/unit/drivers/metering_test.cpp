#include "drivers/metering.h"

#include <gtest/gtest.h>

namespace reseau {
namespace {

constexpr Exposures kBalance = {100000, 80000, 50000, 300000};
constexpr ExposureLimits kLimits = {1, 0x03FFFFFF};

// A linear sensor that cuts off at full scale.
Levels levels_of(const Exposures& exposures, const std::array<double, 4>& per_10ns) {
  Levels levels;
  for (std::size_t i = 0; i < 4; ++i) levels[i] = std::min(1.0, exposures[i] * per_10ns[i]);
  return levels;
}

int passes_until_done(Metering& metering, const std::array<double, 4>& per_10ns) {
  for (int pass = 1; pass <= 20; ++pass) {
    if (metering.improve(levels_of(metering.exposures(), per_10ns))) return pass;
  }
  return 100;
}

TEST(Metering, ReachesTheTargetInOneStepFromAnUnclippedPass) {
  Metering metering(kBalance, kLimits);
  const std::array<double, 4> film = {0.4e-5, 0.45e-5, 0.5e-5, 0.2e-5};
  EXPECT_EQ(passes_until_done(metering, film), 1);
  const Levels after = levels_of(metering.exposures(), film);
  EXPECT_NEAR(*after[0], 0.90, 1e-4) << "red was the brightest";
  EXPECT_NEAR(*after[3], 0.90, 1e-4);
}

TEST(Metering, KeepsTheRatiosOfTheVisibleChannels) {
  Metering metering(kBalance, kLimits);
  passes_until_done(metering, {0.2e-5, 0.9e-5, 0.1e-5, 0.3e-5});
  const Exposures e = metering.exposures();
  EXPECT_NEAR(double(e[0]) / e[1], 100000.0 / 80000, 1e-4);
  EXPECT_NEAR(double(e[2]) / e[1], 50000.0 / 80000, 1e-4);
}

TEST(Metering, HalvesUntilNothingIsClipped) {
  Metering metering(kBalance, kLimits);
  const std::array<double, 4> film = {8e-5, 1e-5, 1e-5, 0.2e-5};
  EXPECT_EQ(passes_until_done(metering, film), 5);
  EXPECT_NEAR(*levels_of(metering.exposures(), film)[0], 0.90, 1e-3);
}

TEST(Metering, MetersInfraredByItself) {
  Metering metering(kBalance, kLimits);
  const std::array<double, 4> film = {0.4e-5, 0.4e-5, 0.4e-5, 0.2e-5};
  passes_until_done(metering, film);
  const Exposures visible = metering.exposures();
  Metering other(kBalance, kLimits);
  passes_until_done(other, {0.4e-5, 0.4e-5, 0.4e-5, 0.02e-5});
  EXPECT_EQ(visible[0], other.exposures()[0]);
  EXPECT_NE(visible[3], other.exposures()[3]);
}

TEST(Metering, StopsAtTheLongestExposureWithTheRatiosKept) {
  Metering metering(kBalance, {1, 1000000});
  EXPECT_LE(passes_until_done(metering, {1e-9, 1e-9, 1e-9, 1e-9}), 3);
  const Exposures e = metering.exposures();
  EXPECT_EQ(e[0], 1000000U);
  EXPECT_EQ(e[1], 800000U);
}

TEST(Metering, SurvivesAUnitWithoutWhiteBalance) {
  Metering metering({0, 0, 0, 0}, kLimits);
  for (const std::uint32_t e : metering.exposures()) EXPECT_GE(e, 1U);
}

TEST(LevelHistogram, IgnoresTheBrightestThousandth) {
  LevelHistogram histogram(1);
  std::vector<std::uint16_t> line(10000, 32768);
  for (std::size_t i = 0; i < 9; ++i) line[i] = 65535;
  histogram.add_line(line);
  EXPECT_NEAR(*histogram.high_level(0), 0.5, 1e-3);
  for (std::size_t i = 0; i < 20; ++i) line[i] = 65535;
  histogram.add_line(line);
  EXPECT_EQ(*histogram.high_level(0), 1.0);
}

TEST(LevelHistogram, HasNoLevelBeforeTheFirstLine) {
  EXPECT_FALSE(LevelHistogram(1).high_level(0));
}

}  // namespace
}  // namespace reseau
