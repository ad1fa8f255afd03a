#include "core/color/rgb_space.h"

#include <cmath>
#include <random>

#include <ImfChromaticities.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

namespace reseau {
namespace {

TEST(XyzFromRgb, GivesTheMatrixOfSrgb) {
  // From its primaries and white; seven digits as commonly printed.
  const Matrix3 printed{0.4123908, 0.3575843, 0.1804808, 0.2126390, 0.7151687,
                        0.0721923, 0.0193308, 0.1191948, 0.9505322};
  const Matrix3 own = xyz_from_rgb(srgb_chromaticities());
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_NEAR(own[i], printed[i], 1e-7);
  }
}

TEST(XyzFromRgb, IsWhatOpenExrComputes) {
  const Chromaticities space{
      {{{0.6456, 0.3467}, {0.2917, 0.6484}, {0.1446, 0.0795}, {0.336, 0.303}}}};
  const auto v2f = [&space](std::size_t i) {
    return Imath::V2f(static_cast<float>(space.xy[i][0]), static_cast<float>(space.xy[i][1]));
  };
  const Imf::Chromaticities theirs(v2f(0), v2f(1), v2f(2), v2f(3));
  const Imath::M44f expected = Imf::RGBtoXYZ(theirs, 1.0f);  // acts on row vectors
  const Matrix3 own = xyz_from_rgb(space);
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t col = 0; col < 3; ++col) {
      EXPECT_NEAR(own[3 * row + col], expected[int(col)][int(row)], 2e-6);
    }
  }
}

TEST(XyzFromRgb, RefusesPrimariesOnALine) {
  EXPECT_THROW((void)xyz_from_rgb({{{{0.1, 0.1}, {0.2, 0.2}, {0.3, 0.3}, {0.31, 0.33}}}}),
               InputError);
  EXPECT_THROW((void)xyz_from_rgb({{{{0.6, 0.3}, {0.3, 0.6}, {0.1, 0.1}, {0.31, 0.0}}}}),
               InputError);
}

TEST(SrgbFromXyz, WhiteIsExactlyOne) {
  const Rgb white = multiply(srgb_from_xyz_d65(), white_of(Illuminant::kD65));
  for (const double v : white) {
    EXPECT_NEAR(v, 1.0, 1e-14);
  }
}

TEST(SrgbFromXyz, DiffersFromThePrintedMatrixOnlyByTheRoundingOfD65) {
  const Matrix3 printed{3.2409699, -1.5373832, -0.4986108, -0.9692436, 1.8759675,
                        0.0415551, 0.0556301,  -0.2039770, 1.0569715};
  const Matrix3 own = srgb_from_xyz_d65();
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_NEAR(own[i], printed[i], 4e-4);
  }
}

TEST(SrgbCurve, KnownValuesAndRoundTrip) {
  EXPECT_EQ(srgb_encode(0), 0);
  EXPECT_DOUBLE_EQ(srgb_encode(1), 1);
  EXPECT_NEAR(srgb_encode(0.5), 0.7353570, 1e-6);
  EXPECT_NEAR(srgb_encode(0.18), 0.4613561, 1e-6);
  EXPECT_NEAR(srgb_decode(0.5), 0.2140411, 1e-6);
  EXPECT_NEAR(srgb_encode(0.0031308), 12.92 * 0.0031308, 1e-9);
  for (double v = -1.5; v <= 1.5; v += 0.01) {
    EXPECT_NEAR(srgb_decode(srgb_encode(v)), v, 1e-7);
  }
}

TEST(Gamut, LuminanceOfWhiteIsOne) {
  EXPECT_NEAR(srgb_luminance({1, 1, 1}), 1.0, 1e-15);
  EXPECT_NEAR(srgb_luminance({0, 1, 0}), 0.7151687, 1e-7);
}

TEST(Gamut, ColoursInsideStayAsTheyAre) {
  const Rgb inside{0.1, 0.9, 0.0};
  EXPECT_EQ(desaturate_into_gamut(inside), inside);
}

TEST(Gamut, ColoursOutsideKeepLuminanceAndHueDirection) {
  const Rgb cyan{-0.2, 0.6, 0.7};
  const Rgb out = desaturate_into_gamut(cyan);
  EXPECT_TRUE(in_gamut(out));
  EXPECT_NEAR(srgb_luminance(out), srgb_luminance(cyan), 1e-12);
  EXPECT_NEAR(out[0], 0, 1e-15);
  EXPECT_LT(out[1], out[2]);
}

TEST(Gamut, AnythingFiniteEndsInside) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> value(-3, 3);
  for (int i = 0; i < 1000; ++i) {
    const Rgb rgb{value(random), value(random), value(random)};
    const Rgb out = desaturate_into_gamut(rgb);
    EXPECT_TRUE(in_gamut(out));
    EXPECT_NEAR(srgb_luminance(out), std::clamp(srgb_luminance(rgb), 0.0, 1.0), 1e-12);
  }
}

}  // namespace
}  // namespace reseau
