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

// A locus that folds back on itself: the ray along x crosses it at 0.5, 0.8 and 0.6. The outermost
// crossing counts, whichever comes first or last along the wavelengths.
TEST(DominantWavelength, IsThatOfTheOutermostCrossing) {
  const std::vector<Chromaticity> points{{0.5, 0.2}, {0.5, 0.0}, {0.8, 0.0},
                                         {0.8, 0.2}, {0.6, 0.2}, {0.6, 0.0}};
  const auto observer_of_points = [](const std::vector<Chromaticity>& locus) {
    Observer observer;
    observer.grid = {400, 10, static_cast<int>(locus.size())};
    for (const Chromaticity& c : locus) {
      observer.xbar.push_back(c[0]);
      observer.ybar.push_back(c[1]);
      observer.zbar.push_back(1 - c[0] - c[1]);
    }
    return observer;
  };
  const Chromaticity white{0.3, 0.1}, color{0.4, 0.1};
  EXPECT_NEAR(dominant_wavelength_nm(color, white, observer_of_points(points)).value(), 425, 1e-9);
  const std::vector<Chromaticity> backwards(points.rbegin(), points.rend());
  EXPECT_NEAR(dominant_wavelength_nm(color, white, observer_of_points(backwards)).value(), 425,
              1e-9);
}

TEST(DominantWavelength, IsAbsentForPurplesAndForWhite) {
  EXPECT_FALSE(dominant_wavelength_nm({0.35, 0.15}, kE, observer_5nm()).has_value());
  EXPECT_FALSE(dominant_wavelength_nm(kE, kE, observer_5nm()).has_value());
}

TEST(DominantWavelength, AgreesWithTheReferenceTable) {
  int compared = 0;
  for (const CsvRow& row : read_reference_table("dominant_wavelengths.csv")) {
    const Chromaticity white{number(row, "white_x"), number(row, "white_y")};
    const Chromaticity blue =
        row.at("set") == "hubicka-2025" ? kTab2Blue : Chromaticity{0.14, 0.089};
    const std::pair<const char*, Chromaticity> elements[] = {
        {"red", kTab2Red}, {"green", kTab2Green}, {"blue", blue}};
    for (const auto& [element, color] : elements) {
      const auto own = dominant_wavelength_nm(color, white, observer_5nm());
      ASSERT_TRUE(own.has_value());
      EXPECT_NEAR(*own, number(row, element), 0.02) << row.at("set") << " " << white[0];
      ++compared;
    }
  }
  EXPECT_EQ(compared, 42);
}

}  // namespace
}  // namespace reseau
