// lcms2 as an independent witness of Bradford, CIELAB and CIEDE2000.
#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <lcms2.h>

#include "core/color/adaptation.h"
#include "core/color/delta_e.h"

namespace reseau {
namespace {

cmsCIEXYZ to_lcms(const Xyz& xyz) { return {xyz[0], xyz[1], xyz[2]}; }

TEST(LcmsOracle, BradfordBetweenAllIlluminants) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> value(0.05, 1);
  for (const Illuminant from : {Illuminant::kA, Illuminant::kB, Illuminant::kC, Illuminant::kE}) {
    for (const Illuminant to : {Illuminant::kD50, Illuminant::kD65}) {
      const Xyz source = white_of(from), target = white_of(to);
      for (int i = 0; i < 20; ++i) {
        const Xyz color{value(random), value(random), value(random)};
        const Xyz own = multiply(bradford_target_from_source(source, target), color);
        cmsCIEXYZ theirs{};
        const cmsCIEXYZ lcms_source = to_lcms(source), lcms_target = to_lcms(target),
                        lcms_color = to_lcms(color);
        ASSERT_TRUE(cmsAdaptToIlluminant(&theirs, &lcms_source, &lcms_target, &lcms_color));
        EXPECT_NEAR(own[0], theirs.X, 1e-6);
        EXPECT_NEAR(own[1], theirs.Y, 1e-6);
        EXPECT_NEAR(own[2], theirs.Z, 1e-6);
      }
    }
  }
}

TEST(LcmsOracle, LabAndItsDifference) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> value(0.0005, 1.2);
  const Xyz white = white_of(Illuminant::kD65);
  const cmsCIEXYZ lcms_white = to_lcms(white);
  for (int i = 0; i < 500; ++i) {
    std::array<Lab, 2> own{};
    std::array<cmsCIELab, 2> theirs{};
    for (std::size_t k = 0; k < 2; ++k) {
      const Xyz color{value(random), value(random), value(random)};
      const cmsCIEXYZ lcms_color = to_lcms(color);
      own[k] = lab_from_xyz(color, white);
      cmsXYZ2Lab(&lcms_white, &theirs[k], &lcms_color);
      EXPECT_NEAR(own[k][0], theirs[k].L, 2e-4);  // lcms rounds the constants of the straight foot
      EXPECT_NEAR(own[k][1], theirs[k].a, 1e-3);
      EXPECT_NEAR(own[k][2], theirs[k].b, 1e-3);
      theirs[k] = {own[k][0], own[k][1], own[k][2]};
    }
    EXPECT_NEAR(delta_e_2000(own[0], own[1]), cmsCIE2000DeltaE(&theirs[0], &theirs[1], 1, 1, 1),
                1e-9);
  }
}

}  // namespace
}  // namespace reseau
