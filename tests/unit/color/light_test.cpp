#include "core/color/light.h"

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace reseau {
namespace {

TEST(Light, WordsAreRead) {
  EXPECT_EQ(parse_light("B").spectrum.values, illuminant_spectrum(Illuminant::kB).values);
  EXPECT_EQ(parse_light("5500K").spectrum.values, daylight_spectrum(5500).values);
  EXPECT_EQ(parse_light("5500").spectrum.values, parse_light("daylight:5500K").spectrum.values);
  // Where daylight is not defined a temperature is that of a lamp.
  EXPECT_EQ(parse_light("3200K").spectrum.values, planckian(3200).spectrum.values);
  EXPECT_EQ(parse_light("3200K").name, "black body of 3200 K");
  EXPECT_EQ(parse_light("4000K").name, "daylight of 4000 K");
  EXPECT_EQ(parse_light("planck:2856").spectrum.values, planckian(2856).spectrum.values);
  for (const char* word :
       {"", "K", "D", "tungsten", "999K", "daylight:3999", "25001K", "planck:999", "planck:25001",
        "planck:", "5500 K", "1e9999", "nan", "D9"}) {
    EXPECT_THROW((void)parse_light(word), InputError) << word;
  }
}

// CIE 15:2018, tables T.3: the 2 degree observer.
TEST(Light, WhitesOfColorTemperatures) {
  const struct {
    const char* word;
    double x, y, within;
  } cases[] = {{"D55", 0.33243, 0.34744, 5e-5},
               {"D75", 0.29903, 0.31488, 5e-5},
               {"D65", 0.31272, 0.32903, 5e-5},
               // A is a black body of 2848 K with c2 = 1.435e7 nm K, 2855.5 K with today's.
               {"planck:2855.54", 0.44758, 0.40745, 5e-5},
               // Planckian locus, Wyszecki and Stiles 1982, table I(6.4.1).
               {"planck:5000", 0.3451, 0.3516, 2e-4},
               {"planck:10000", 0.2806, 0.2883, 2e-4}};
  for (const auto& each : cases) {
    const Light light = parse_light(each.word);
    for (const SummationStep step : {SummationStep::k5nm, SummationStep::k1nm}) {
      const Chromaticity xy = chromaticity_of(white_of(light, step));
      EXPECT_NEAR(xy[0], each.x, each.within) << each.word;
      EXPECT_NEAR(xy[1], each.y, each.within) << each.word;
    }
  }
}

TEST(Light, StepsOfOneAndFiveAgree) {
  EXPECT_EQ(observer_of(SummationStep::k1nm).grid, (WavelengthGrid{380, 1, 401}));
  EXPECT_EQ(observer_of(SummationStep::k1nm).xbar.size(), 401u);
  EXPECT_EQ(observer_of(SummationStep::k1nm).ybar[0], observer_1nm().ybar[20]);
  EXPECT_EQ(parse_summation_step("1"), SummationStep::k1nm);
  EXPECT_THROW((void)parse_summation_step("10"), InputError);
  for (const Illuminant illuminant :
       {Illuminant::kA, Illuminant::kB, Illuminant::kC, Illuminant::kD50, Illuminant::kD65}) {
    const Xyz fine = white_of(light_of(illuminant), SummationStep::k1nm);
    const Xyz coarse = white_of(light_of(illuminant), SummationStep::k5nm);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(fine[i], coarse[i], 1e-3);
  }
}

}  // namespace
}  // namespace reseau
