#include "core/color/dominant_wavelength.h"

#include <gtest/gtest.h>

#include "tests/unit/color/reference_tables.h"

namespace reseau {
namespace {

constexpr Chromaticity kE{1.0 / 3, 1.0 / 3};
constexpr Chromaticity kTab2Red{0.633, 0.365};
constexpr Chromaticity kTab2Green{0.233, 0.647};
constexpr Chromaticity kTab2Blue{0.164, 0.089};

TEST(DominantWavelength, OfTheCorrectedSetUnderEqualEnergy) {
  EXPECT_NEAR(dominant_wavelength_nm(kTab2Red, kE, observer_5nm()).value(), 601.74, 0.02);
  EXPECT_NEAR(dominant_wavelength_nm(kTab2Green, kE, observer_5nm()).value(), 534.52, 0.02);
  EXPECT_NEAR(dominant_wavelength_nm(kTab2Blue, kE, observer_5nm()).value(), 466.16, 0.02);
}

// The 534.8 nm that the literature gives for E belongs to a white rounded to two digits.
TEST(DominantWavelength, OfTheGreenNeedsARoundedWhiteToComeOutAsPublished) {
  EXPECT_NEAR(dominant_wavelength_nm(kTab2Green, {0.33, 0.33}, observer_5nm()).value(), 534.8, 0.1);
  EXPECT_NEAR(dominant_wavelength_nm(kTab2Green, kE, observer_5nm()).value(), 534.5, 0.1);
}

TEST(DominantWavelength, FinerSegmentsMoveItByAFifthOfANanometreAtMost) {
  for (const Chromaticity& c : {kTab2Red, kTab2Green, kTab2Blue}) {
    const double coarse = dominant_wavelength_nm(c, kE, observer_5nm()).value();
    const double fine = dominant_wavelength_nm(c, kE, observer_1nm()).value();
    EXPECT_NE(coarse, fine);
    EXPECT_NEAR(coarse, fine, 0.22);
  }
}

TEST(DominantWavelength, OfALocusPointIsItsOwn) {
  const Observer& o = observer_5nm();
  const Chromaticity at_520 = chromaticity_of({o.xbar[28], o.ybar[28], o.zbar[28]});
  EXPECT_NEAR(dominant_wavelength_nm(at_520, kE, o).value(), 520, 1e-9);
}

TEST(DominantWavelength, IsAbsentForPurplesAndForWhite) {
  EXPECT_FALSE(dominant_wavelength_nm({0.35, 0.15}, kE, observer_5nm()).has_value());
  EXPECT_FALSE(dominant_wavelength_nm(kE, kE, observer_5nm()).has_value());
}

TEST(DominantWavelength, AgreesWithTheReferenceTable) {
  const auto rows = read_reference_table("expected_dominant_wavelengths.csv");
  const auto whites = read_reference_table("white_points.csv");
  const auto sets = read_reference_table("primaries.csv");
  if (!rows || !whites || !sets) {
    GTEST_SKIP() << "the reference tables are not on this machine";
  }
  int compared = 0;
  for (const CsvRow& row : *rows) {
    const std::string& set = row.at("set");
    if (set == "published") {
      continue;
    }
    Chromaticity white{0.33, 0.33};
    for (const CsvRow& each : *whites) {
      if (each.at("illuminant") == row.at("white")) {
        white = {number(each, "x"), number(each, "y")};
      }
    }
    for (const CsvRow& element : *sets) {
      if (element.at("set") != (set == "tab1" ? "cornwell_clyne_1951_tab1" : "hubicka_2025_tab2")) {
        continue;
      }
      const auto own = dominant_wavelength_nm({number(element, "x"), number(element, "y")},
                                              row.at("white") == "E" ? kE : white, observer_5nm());
      ASSERT_TRUE(own.has_value());
      EXPECT_NEAR(*own, number(row, element.at("element")), 0.02) << set << row.at("white");
      ++compared;
    }
  }
  EXPECT_EQ(compared, 42);
}

}  // namespace
}  // namespace reseau
