#include "core/color/colorimetry.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace reseau {
namespace {

struct PublishedWhite {
  const char* name;
  double x, y;
};
// CIE 15:2018 tables T.1 and T.3; B: Wyszecki and Stiles 1982.
constexpr PublishedWhite kPublishedWhites[] = {
    {"A", 0.44758, 0.40745},   {"B", 0.34842, 0.35161},   {"C", 0.31006, 0.31616},
    {"D50", 0.34567, 0.35851}, {"D65", 0.31272, 0.32903}, {"E", 1.0 / 3, 1.0 / 3},
};

TEST(White, IntegratedTablesGiveThePublishedWhitePoints) {
  for (const PublishedWhite& white : kPublishedWhites) {
    const Chromaticity xy = chromaticity_of(white_of(parse_illuminant(white.name)));
    EXPECT_NEAR(xy[0], white.x, 5e-5) << white.name;
    EXPECT_NEAR(xy[1], white.y, 5e-5) << white.name;
  }
}

TEST(White, D65IsTheOneEverythingIsBalancedTo) {
  const Xyz white = white_of(Illuminant::kD65);
  EXPECT_NEAR(white[0], 0.95043, 5e-6);
  EXPECT_EQ(white[1], 1.0);
  EXPECT_NEAR(white[2], 1.08880, 5e-6);
}

TEST(Observer, TheTwoGridsAreOneObserver) {
  const Observer& fine = observer_1nm();
  const Observer& coarse = observer_5nm();
  ASSERT_EQ(fine.grid, (WavelengthGrid{360, 1, 471}));
  ASSERT_EQ(coarse.grid, (WavelengthGrid{380, 5, 81}));
  for (std::size_t i = 0; i < coarse.ybar.size(); ++i) {
    const std::size_t j = 20 + 5 * i;
    EXPECT_NEAR(coarse.xbar[i], fine.xbar[j], 6e-7);
    EXPECT_NEAR(coarse.ybar[i], fine.ybar[j], 6e-7);
    EXPECT_NEAR(coarse.zbar[i], fine.zbar[j], 6e-7);
  }
  EXPECT_EQ(coarse.ybar[35], 1.0);  // 555 nm
}

TEST(Illuminant, AFollowsPlancksFormula) {
  const Spectrum& a = illuminant_spectrum(Illuminant::kA);
  for (std::size_t i = 0; i < a.values.size(); ++i) {
    const double nm = a.grid.wavelength_nm(static_cast<int>(i));
    const double c2 = 1.435e7 / 2848;
    EXPECT_NEAR(a.values[i],
                100 * std::pow(560 / nm, 5) * std::expm1(c2 / 560) / std::expm1(c2 / nm), 1e-5);
  }
}

TEST(Illuminant, NamesAreRead) {
  EXPECT_EQ(parse_illuminant("D50"), Illuminant::kD50);
  try {
    (void)parse_illuminant("d65");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("D65"), std::string::npos);
  }
}

TEST(Daylight, MakesD50AndD65FromTheirComponents) {
  const struct {
    Illuminant illuminant;
    double nominal_k;
  } cases[] = {{Illuminant::kD50, 5000}, {Illuminant::kD65, 6500}};
  for (const auto& each : cases) {
    const Spectrum made = daylight_spectrum(each.nominal_k * 1.4388 / 1.4380);
    const Spectrum& table = illuminant_spectrum(each.illuminant);
    ASSERT_EQ(made.grid, table.grid);
    for (std::size_t i = 0; i < made.values.size(); ++i) {
      EXPECT_NEAR(made.values[i], table.values[i], 2e-3) << made.grid.wavelength_nm(int(i));
    }
  }
}

TEST(Daylight, IsContinuousWhereTheFormulaChanges) {
  const Xyz below = white_of(daylight_spectrum(7000), observer_5nm());
  const Xyz above = white_of(daylight_spectrum(7000.001), observer_5nm());
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(below[i], above[i], 2e-3);
  }
}

TEST(Daylight, RefusesTemperaturesWithoutDaylight) {
  EXPECT_THROW((void)daylight_spectrum(3999), InputError);
  EXPECT_THROW((void)daylight_spectrum(25001), InputError);
  EXPECT_THROW((void)daylight_spectrum(std::nan("")), InputError);
}

TEST(Integration, AGreyFilterScalesTheLight) {
  const Spectrum grey{observer_5nm().grid, std::vector<double>(81, 0.25)};
  const Xyz xyz = xyz_from_transmittance(grey, illuminant_spectrum(Illuminant::kC), observer_5nm());
  const Xyz white = white_of(Illuminant::kC);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(xyz[i], white[i] / 4, 1e-15);
  }
}

TEST(Integration, TheFinerObserverChangesLittle) {
  const Xyz coarse = white_of(Illuminant::kD65);
  const Xyz fine = white_of(resample(illuminant_spectrum(Illuminant::kD65), observer_1nm().grid),
                            observer_1nm());
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(coarse[i], fine[i], 3e-4);
  }
}

TEST(Chromaticity, RoundTripsAndHandlesBlack) {
  const Chromaticity xy = chromaticity_of(xyz_from_chromaticity({0.233, 0.647}, 0.43));
  EXPECT_NEAR(xy[0], 0.233, 1e-15);
  EXPECT_NEAR(xy[1], 0.647, 1e-15);
  EXPECT_EQ(chromaticity_of({0, 0, 0}), (Chromaticity{0, 0}));
  EXPECT_THROW((void)xyz_from_chromaticity({0.3, 0}, 1), InputError);
  EXPECT_THROW((void)xyz_from_chromaticity({std::nan(""), 0.3}, 1), InputError);
}

}  // namespace
}  // namespace reseau
