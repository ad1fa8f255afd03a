#include "core/color/primaries.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/color/balance.h"
#include "core/color/dominant_wavelength.h"
#include "core/color/tables.h"
#include "tests/unit/color/reference_tables.h"

namespace reseau {
namespace {

TEST(PrimarySets, ThoseOfThePaperStandFirst) {
  const auto names = primary_set_names();
  ASSERT_EQ(names.size(), 24u);
  EXPECT_EQ(std::vector<std::string>(names.begin(), names.begin() + 7),
            (std::vector<std::string>{"cornwell-clyne-1951", "harrison-horner-1939",
                                      "collins-giles-1952", "neblette-1952",
                                      "cornwell-clyne-1951-tab1", "hubicka-2025", "srgb"}));
}

TEST(PrimarySets, EachNamesItsSource) {
  for (const PrimarySet& set : primary_sets()) {
    EXPECT_NE(set.source.find("Source"), std::string::npos) << set.name;
    EXPECT_NE(set.source.find("Quantity"), std::string::npos) << set.name;
    EXPECT_FALSE(set.about.empty()) << set.name;
    EXPECT_NE(set.charts.has_value(), set.stated.has_value()) << set.name;
  }
  ASSERT_EQ(dye_tables().size(), 1u);
  EXPECT_EQ(dye_tables().front().dyes.size(), 11u);
}

TEST(PrimarySets, AnUnknownNameIsRefusedWithTheKnownOnes) {
  try {
    (void)element_primaries("kodachrome", Illuminant::kD65);
    FAIL();
  } catch (const InputError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("kodachrome"), std::string::npos);
    EXPECT_NE(text.find("neblette-1952"), std::string::npos);
    EXPECT_NE(text.find("hubicka-2025"), std::string::npos);
  }
}

TEST(PrimarySets, SpectraOfDufaycolorLieInTheVisibleAndInRange) {
  for (const char* name :
       {"cornwell-clyne-1951", "harrison-horner-1939", "collins-giles-1952", "neblette-1952"}) {
    const PrimarySet& set = find_primary_set(name);
    for (const auto& points : set.charts.value().points) {
      EXPECT_GT(points.size(), 35u) << name;
      for (const ChartPoint& point : points) {
        EXPECT_GE(point.wavelength_nm, 398) << name;
        EXPECT_LE(point.wavelength_nm, 721) << name;
        EXPECT_GE(point.value, -0.003) << name;
        EXPECT_LE(point.value, 1) << name;
      }
    }
  }
}

struct Expected {
  const char* set;
  Illuminant light;
  int element;
  double x, y, luminance;
};

// Computed independently from the same charts.
TEST(ElementPrimaries, KnownValues) {
  const Expected cases[] = {
      {"harrison-horner-1939", Illuminant::kC, 0, 0.64281, 0.34973, 0.19020},
      {"harrison-horner-1939", Illuminant::kC, 1, 0.25821, 0.58696, 0.41295},
      {"harrison-horner-1939", Illuminant::kC, 2, 0.14455, 0.08374, 0.08689},
      {"harrison-horner-1939", Illuminant::kD65, 1, 0.25464, 0.59603, 0.42030},
      {"harrison-horner-1939", Illuminant::kE, 2, 0.14750, 0.08886, 0.07794},
      {"cornwell-clyne-1951", Illuminant::kA, 0, 0.65854, 0.33936, 0.27661},
  };
  for (const Expected& e : cases) {
    const Xyz xyz = column(element_primaries(e.set, e.light), e.element);
    const Chromaticity xy = chromaticity_of(xyz);
    EXPECT_NEAR(xy[0], e.x, 2e-5) << e.set;
    EXPECT_NEAR(xy[1], e.y, 2e-5) << e.set;
    EXPECT_NEAR(xyz[1], e.luminance, 2e-5) << e.set;
  }
}

TEST(ElementPrimaries, OfChromaticitiesAreAsStatedUnderTheirOwnIlluminant) {
  const Matrix3 c = element_primaries("hubicka-2025", Illuminant::kC);
  EXPECT_EQ(c, element_primaries_as_stated("hubicka-2025", Illuminant::kD65));
  EXPECT_NEAR(chromaticity_of(column(c, 2))[0], 0.164, 1e-15);
  EXPECT_NEAR(column(c, 2)[1], 0.087, 1e-15);
  EXPECT_NE(c, element_primaries("hubicka-2025", Illuminant::kD65));
}

TEST(ElementPrimaries, AgreeWithTheReferenceTable) {
  const auto rows = read_reference_table("element_primaries.csv");
  int compared = 0;
  for (const CsvRow& row : rows) {
    const Illuminant light = parse_illuminant(row.at("illuminant"));
    const int element = row.at("element") == "red" ? 0 : row.at("element") == "green" ? 1 : 2;
    const Xyz xyz = column(element_primaries(row.at("set"), light), element);
    const Chromaticity xy = chromaticity_of(xyz);
    EXPECT_NEAR(xy[0], number(row, "x"), 2e-5) << row.at("set");
    EXPECT_NEAR(xy[1], number(row, "y"), 2e-5);
    EXPECT_NEAR(xyz[1], number(row, "Y"), 2e-5);
    const auto nm = dominant_wavelength_nm(xy, chromaticity_of(white_of(light)), observer_5nm());
    ASSERT_EQ(nm.has_value(), !row.at("dominant_wavelength_nm").empty());
    if (nm) {
      EXPECT_NEAR(*nm, number(row, "dominant_wavelength_nm"), 0.051);
    }
    ++compared;
  }
  EXPECT_EQ(compared, 11 * 6 * 3);
}

// Printed as 42.1, 26.5 and 31.4 percent.
TEST(Areas, OfTheMicrograph) {
  const Vector3 areas = dufaycolor_areas();
  EXPECT_NEAR(areas[0], 0.421, 5e-4);
  EXPECT_NEAR(areas[1], 0.265, 5e-4);
  EXPECT_NEAR(areas[2], 0.314, 5e-4);
  EXPECT_NEAR(areas[0], 21.0 / 49.9, 1e-12);
  EXPECT_NEAR(areas[0] + areas[1] + areas[2], 1.0, 1e-15);
}

TEST(Reseau, ColorAndNeutralFactorsAgreeWithTheReferenceTable) {
  const auto rows = read_reference_table("reseau_colors.csv");
  int compared = 0;
  for (const CsvRow& row : rows) {
    const Illuminant light = parse_illuminant(row.at("illuminant"));
    const Vector3 areas = dufaycolor_areas();
    const Matrix3 weighted =
        scale_columns(element_primaries_as_stated(row.at("set"), light), areas);
    const Xyz reseau = reseau_color(weighted);
    const Vector3 k = neutral_factors(weighted, white_of(light));
    const double covered = k[0] * areas[0] + k[1] * areas[1] + k[2] * areas[2];
    EXPECT_NEAR(chromaticity_of(reseau)[0], number(row, "x"), 1e-4);
    EXPECT_NEAR(chromaticity_of(reseau)[1], number(row, "y"), 1e-4);
    EXPECT_NEAR(reseau[1], number(row, "Y"), 1e-4);
    const char* names[] = {"red", "green", "blue"};
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(k[i], number(row, std::string("k_") + names[i]), 1e-4);
      EXPECT_NEAR(100 * k[i] * areas[i] / covered, number(row, std::string("area_") + names[i]),
                  0.0051);
    }
    ++compared;
  }
  EXPECT_EQ(compared, 6 * 4);
}

}  // namespace
}  // namespace reseau
