#include "core/color/delta_e.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/unit/color/reference_tables.h"

namespace reseau {
namespace {

const Xyz kD65{0.95043, 1.0, 1.08880};

TEST(Lab, OfWhiteBlackAndMiddleGrey) {
  EXPECT_EQ(lab_from_xyz(kD65, kD65), (Lab{100, 0, 0}));
  const Lab black = lab_from_xyz({0, 0, 0}, kD65);
  for (const double v : black) {
    EXPECT_NEAR(v, 0, 1e-12);
  }
  const Lab grey = lab_from_xyz({0.18 * kD65[0], 0.18, 0.18 * kD65[2]}, kD65);
  EXPECT_NEAR(grey[0], 49.4961, 1e-4);
  EXPECT_NEAR(grey[1], 0, 1e-12);
}

TEST(Lab, NegativeCountsAsBlackAndAboveWhiteGoesOn) {
  EXPECT_EQ(lab_from_xyz({-0.1, -0.2, -0.3}, kD65), lab_from_xyz({0, 0, 0}, kD65));
  EXPECT_NEAR(lab_from_xyz({8 * kD65[0], 8, 8 * kD65[2]}, kD65)[0], 216, 1e-9);
}

TEST(Lab, IsContinuousWhereTheFootBegins) {
  const double foot = 216.0 / 24389.0;
  EXPECT_NEAR(lab_from_xyz({0, foot - 1e-12, 0}, kD65)[0], 8.0, 1e-8);
  EXPECT_NEAR(lab_from_xyz({0, foot + 1e-12, 0}, kD65)[0], 8.0, 1e-8);
}

TEST(DeltaE2000, AllPublishedPairsInBothOrders) {
  const auto rows = read_reference_table("ciede2000_pairs.csv");
  ASSERT_EQ(rows.size(), 34u);
  for (const CsvRow& row : rows) {
    const Lab first{number(row, "L1"), number(row, "a1"), number(row, "b1")};
    const Lab second{number(row, "L2"), number(row, "a2"), number(row, "b2")};
    EXPECT_NEAR(delta_e_2000(first, second), number(row, "dE00"), 5e-5) << row.at("pair");
    EXPECT_NEAR(delta_e_2000(second, first), number(row, "dE00"), 5e-5) << row.at("pair");
  }
}

TEST(DeltaE2000, IsSymmetricFiniteAndZeroOnlyForEquals) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> lightness(0, 150), ab(-150, 150);
  for (int i = 0; i < 20000; ++i) {
    const Lab a{lightness(random), ab(random), ab(random)};
    const Lab b{lightness(random), ab(random), ab(random)};
    const double d = delta_e_2000(a, b);
    EXPECT_GT(d, 0);
    EXPECT_TRUE(std::isfinite(d));
    EXPECT_NEAR(d, delta_e_2000(b, a), 1e-9);
    EXPECT_EQ(delta_e_2000(a, a), 0);
  }
}

TEST(DeltaE2000, PassesNotANumberOn) {
  EXPECT_TRUE(std::isnan(delta_e_2000({std::nan(""), 0, 0}, {50, 0, 0})));
}

TEST(Summary, LeavesTheWorstOut) {
  std::vector<double> samples;
  for (int i = 100; i >= 1; --i) {
    samples.push_back(i);
  }
  const DeltaESummary all = summarize_delta_e(samples, 0);
  EXPECT_EQ(all.n, 100u);
  EXPECT_DOUBLE_EQ(all.mean, 50.5);
  EXPECT_EQ(all.p95, 95);
  EXPECT_EQ(all.max, 100);
  const DeltaESummary cut = summarize_delta_e(samples, 0.01);
  EXPECT_EQ(cut.n, 99u);
  EXPECT_DOUBLE_EQ(cut.mean, 50);
  EXPECT_EQ(cut.max, 99);
}

TEST(Summary, OfNothingIsZero) {
  std::vector<double> none;
  EXPECT_EQ(summarize_delta_e(none, 0.01).n, 0u);
  std::vector<double> one{3};
  EXPECT_EQ(summarize_delta_e(one, 1.0).n, 0u);
  EXPECT_EQ(summarize_delta_e(one, 0.01).p95, 3);
}

}  // namespace
}  // namespace reseau
