// What becomes, in view copies, of colours that sRGB does not have: properties of both ways, on
// colours inside, at the border, far beyond it, and on numbers that are no colours.
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "capture/image/view_encoding.h"
#include "core/color/delta_e.h"
#include "core/color/dominant_wavelength.h"
#include "core/color/rgb_space.h"

namespace reseau {
namespace {

constexpr std::array<double, 9> kAsTheyAre{1, 0, 0, 0, 1, 0, 0, 0, 1};

Rgb random_rgb(std::mt19937& random, double low, double high) {
  std::uniform_real_distribution<double> value(low, high);
  return {value(random), value(random), value(random)};
}

Rgb along(const Rgb& direction, double grey, double chroma) {
  return {grey + chroma * direction[0], grey + chroma * direction[1], grey + chroma * direction[2]};
}

// A direction of hue: luminance 0, length 1.
Rgb random_hue(std::mt19937& random) {
  Rgb d = random_rgb(random, -1, 1);
  const double y = srgb_luminance(d);
  for (double& v : d) v -= y;
  const double length = std::hypot(d[0], d[1], d[2]);
  for (double& v : d) v /= length;
  return d;
}

// How far the nearest face of the cube is along a direction.
double chroma_of_border(const Rgb& direction, double grey) {
  double chroma = std::numeric_limits<double>::infinity();
  for (const double d : direction) {
    chroma = std::min(chroma, d > 0 ? (1 - grey) / d : d < 0 ? -grey / d : chroma);
  }
  return chroma;
}

double distance_from(double grey, const Rgb& rgb) {
  return std::hypot(rgb[0] - grey, rgb[1] - grey, rgb[2] - grey);
}

Lab lab_of(const Rgb& rgb) {
  static const Matrix3 xyz = inverse(srgb_from_xyz_d65());
  return lab_from_xyz(multiply(xyz, rgb), white_of(Illuminant::kD65));
}

TEST(PerceptualGamut, LeavesFourFifthsOfTheWayToTheBorderUntouched) {
  std::mt19937 random(1);
  for (int i = 0; i < 2000; ++i) {
    const double grey = std::uniform_real_distribution<double>(0.01, 0.99)(random);
    const Rgb hue = random_hue(random);
    const double border = chroma_of_border(hue, grey);
    for (const double share : {0.0, 0.3, 0.799999}) {
      const Rgb rgb = along(hue, grey, share * border);
      const Rgb out = compress_into_gamut(rgb);
      for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(out[k], rgb[k], 1e-12);
    }
  }
}

// The price of the shoulder: what colours that sRGB has, and that lie near its border, lose.
TEST(PerceptualGamut, ChangesColoursInsideByABoundedAmount) {
  constexpr int kSteps = 20;
  double worst = 0;
  for (int r = 0; r <= kSteps; ++r) {
    for (int g = 0; g <= kSteps; ++g) {
      for (int b = 0; b <= kSteps; ++b) {
        const Rgb rgb{srgb_decode(r / 20.0), srgb_decode(g / 20.0), srgb_decode(b / 20.0)};
        worst = std::max(worst, delta_e_2000(lab_of(rgb), lab_of(compress_into_gamut(rgb))));
      }
    }
  }
  EXPECT_NEAR(worst, 4.49, 0.01);
}

TEST(PerceptualGamut, KeepsLuminanceAndHue) {
  std::mt19937 random(2);
  const Matrix3 xyz = xyz_from_rgb(srgb_chromaticities());
  const Chromaticity white = srgb_chromaticities().xy[3];
  int n_wavelengths = 0;
  for (int i = 0; i < 3000; ++i) {
    const double grey = std::uniform_real_distribution<double>(0.02, 0.98)(random);
    const Rgb hue = random_hue(random);
    const Rgb rgb = along(hue, grey, std::uniform_real_distribution<double>(0, 5)(random));
    const Rgb out = compress_into_gamut(rgb);
    ASSERT_TRUE(in_gamut(out));
    EXPECT_NEAR(srgb_luminance(out), grey, 1e-12);
    // On the straight line to grey of the same luminance: the same dominant wavelength.
    const double chroma = distance_from(grey, out);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(out[k], grey + chroma * hue[k], 1e-12);
    const auto before =
        dominant_wavelength_nm(chromaticity_of(multiply(xyz, rgb)), white, observer_1nm());
    const auto after =
        dominant_wavelength_nm(chromaticity_of(multiply(xyz, out)), white, observer_1nm());
    // Beyond the spectral locus, where X + Y + Z may turn negative, a colour has no wavelength.
    const Xyz seen = multiply(xyz, rgb);
    if (!before || !after || std::ranges::min(seen) <= 0) continue;
    EXPECT_NEAR(*before, *after, 1e-6);
    ++n_wavelengths;
  }
  EXPECT_GT(n_wavelengths, 300);
}

// More chroma in is more chroma out, never a jump, never more than went in.
TEST(PerceptualGamut, RisesAlongChromaWithoutAJump) {
  std::mt19937 random(3);
  for (int i = 0; i < 300; ++i) {
    const double grey = std::uniform_real_distribution<double>(0.02, 0.98)(random);
    const Rgb hue = random_hue(random);
    const double border = chroma_of_border(hue, grey);
    double last = 0;
    for (int step = 1; step <= 400; ++step) {
      const double out =
          distance_from(grey, compress_into_gamut(along(hue, grey, border * step / 40)));
      EXPECT_GT(out, last) << step;
      EXPECT_LE(out - last, border / 40 + 1e-12) << step;
      EXPECT_LE(out, border);
      last = out;
    }
  }
}

TEST(PerceptualGamut, ExtremesBecomeColours) {
  constexpr double kHuge = std::numeric_limits<double>::max(),
                   kTiny = std::numeric_limits<double>::denorm_min();
  const double values[] = {-kHuge, -1e30, -1, -kTiny, -0.0, 0.0, kTiny, 0.5, 1.0, 1e30, kHuge / 4};
  for (const double r : values) {
    for (const double g : values) {
      for (const double b : values) {
        const Rgb rgb{r, g, b}, out = compress_into_gamut(rgb);
        EXPECT_TRUE(in_gamut(out)) << r << " " << g << " " << b;
      }
    }
  }
  // Darker than black is black, brighter than white is white, whatever the hue.
  EXPECT_EQ(compress_into_gamut({-0.2, -0.1, -3}), (Rgb{0, 0, 0}));
  EXPECT_EQ(compress_into_gamut({9, 1.5, 4}), (Rgb{1, 1, 1}));
  EXPECT_EQ(compress_into_gamut({1, 1, 1}), (Rgb{1, 1, 1}));
}

template <typename Sample>
std::vector<Sample> encoded_by(ViewGamut gamut, const std::vector<float>& rgb,
                               std::uint64_t* outside = nullptr) {
  std::vector<Sample> out(rgb.size());
  const std::uint64_t n =
      ViewEncoder(kAsTheyAre, 1, gamut).encode(std::span<const float>(rgb), std::span(out));
  if (outside != nullptr) *outside = n;
  return out;
}

std::vector<float> random_pixels(std::mt19937& random, float low, float high) {
  std::uniform_real_distribution<float> value(low, high);
  std::vector<float> rgb(30000);
  for (float& v : rgb) v = value(random);
  return rgb;
}

TEST(ClipGamut, RoundsWhatIsInsideAndClipsEachComponentByItself) {
  std::mt19937 random(4);
  const auto rgb = random_pixels(random, -0.5F, 1.5F);
  const auto out = encoded_by<std::uint16_t>(ViewGamut::kClip, rgb);
  for (std::size_t i = 0; i < rgb.size(); ++i) {
    const double wanted = srgb_encode(std::clamp(double{rgb[i]}, 0.0, 1.0)) * 65535;
    EXPECT_NEAR(out[i], wanted, 0.52);  // rounding, and the table of the curve
  }
}

TEST(ClipGamut, IsMonotoneAlongEachComponent) {
  std::vector<float> rgb;
  for (int i = -300; i <= 1500; ++i) {
    const float v = static_cast<float>(i) / 1000;
    rgb.insert(rgb.end(), {v, v, v});
  }
  for (const ViewGamut gamut : {ViewGamut::kClip, ViewGamut::kPerceptual}) {
    const auto out = encoded_by<std::uint16_t>(gamut, rgb);
    for (std::size_t i = 3; i < out.size(); ++i) EXPECT_GE(out[i], out[i - 3]);
    EXPECT_EQ(out.front(), 0);
    EXPECT_EQ(out.back(), 65535);
  }
}

// Both count the same pixels; where none is near the border both give the same picture.
TEST(ViewGamuts, AgreeOnWhatIsOutsideAndOnWhatIsWellInside) {
  std::mt19937 random(5);
  std::uint64_t clipped = 0, compressed = 0;
  const auto wild = random_pixels(random, -2, 3);
  (void)encoded_by<std::uint8_t>(ViewGamut::kClip, wild, &clipped);
  (void)encoded_by<std::uint8_t>(ViewGamut::kPerceptual, wild, &compressed);
  EXPECT_EQ(clipped, compressed);
  EXPECT_GT(clipped, 9000U);
  const auto tame = random_pixels(random, 0.4F, 0.6F);
  EXPECT_EQ(encoded_by<std::uint16_t>(ViewGamut::kClip, tame, &clipped),
            encoded_by<std::uint16_t>(ViewGamut::kPerceptual, tame, &compressed));
  EXPECT_EQ(clipped + compressed, 0U);
}

TEST(ViewGamuts, NumbersThatAreNoColoursBecomeBlackOrWhite) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity(),
                  kNan = std::numeric_limits<float>::quiet_NaN(),
                  kMax = std::numeric_limits<float>::max(),
                  kTiny = std::numeric_limits<float>::denorm_min();
  // A matrix that holds zeros turns infinity into NaN, and that is black.
  const struct {
    float value;
    std::uint16_t sample;
    std::uint64_t outside;
  } cases[] = {{-kInfinity, 0, 1}, {-kMax, 0, 1},     {-kTiny, 0, 0}, {kTiny, 0, 0},
               {kMax, 65535, 1},   {kInfinity, 0, 1}, {kNan, 0, 1}};
  for (const ViewGamut gamut : {ViewGamut::kClip, ViewGamut::kPerceptual}) {
    for (const auto& each : cases) {
      std::uint64_t outside = 0;
      const float v = each.value;
      const auto samples = encoded_by<std::uint16_t>(gamut, {v, v, v}, &outside);
      EXPECT_EQ(samples, std::vector<std::uint16_t>(3, each.sample)) << v;
      EXPECT_EQ(outside, each.outside) << v;
    }
  }
}

}  // namespace
}  // namespace reseau
