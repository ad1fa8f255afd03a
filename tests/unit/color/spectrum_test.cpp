#include "core/color/spectrum.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace reseau {
namespace {

TEST(Resample, InterpolatesLinearlyBetweenPoints) {
  const std::vector<ChartPoint> chart{{400, 10}, {420, 30}, {425, 0}};
  const Spectrum s = resample(chart, {400, 5, 6}, 0, 100);
  EXPECT_EQ(s.values, (std::vector<double>{10, 15, 20, 25, 30, 0}));
}

TEST(Resample, ContinuesTheOuterSegmentsAndClamps) {
  const std::vector<ChartPoint> chart{{400, 10}, {405, 6}, {410, 90}};
  const Spectrum s = resample(chart, {390, 5, 6}, 0, 100);
  EXPECT_EQ(s.values, (std::vector<double>{18, 14, 10, 6, 90, 100}));
}

TEST(Resample, KeepsAStraightSpectrumStraightOnAFinerGrid) {
  const Spectrum coarse{{500, 10, 3}, {1, 2, 3}};
  const Spectrum fine = resample(coarse, {495, 5, 6});
  const std::vector<double> expected{0.5, 1, 1.5, 2, 2.5, 3};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_DOUBLE_EQ(fine.values[i], expected[i]);
  }
}

TEST(Resample, RefusesChartsThatCannotBeRead) {
  const WavelengthGrid grid;
  EXPECT_THROW((void)resample(std::vector<ChartPoint>{{400, 1}}, grid, 0, 1), InputError);
  EXPECT_THROW((void)resample(std::vector<ChartPoint>{{400, 1}, {400, 2}}, grid, 0, 1), InputError);
  EXPECT_THROW((void)resample(std::vector<ChartPoint>{{500, 1}, {400, 2}}, grid, 0, 1), InputError);
  EXPECT_THROW((void)resample(std::vector<ChartPoint>{{400, std::nan("")}, {500, 2}}, grid, 0, 1),
               InputError);
}

}  // namespace
}  // namespace reseau
