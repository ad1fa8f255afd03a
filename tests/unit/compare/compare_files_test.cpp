// Whole comparisons whose answer is known.
#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/compare/color_pass.h"
#include "capture/compare/compare.h"
#include "capture/compare/compare_json.h"
#include "core/base/error.h"
#include "core/color/element_color.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/compare/picture_files.h"

namespace reseau::compare {
namespace {

using reseau::test::TempDir;
using ::testing::Contains;
using ::testing::HasSubstr;

constexpr int kSize = 96;

class CompareFiles : public ::testing::Test {
 protected:
  Comparison compare(const char* a, const char* b, const CompareOptions& options = {}) {
    auto result = compare_files(dir / a, dir / b, options, {});
    EXPECT_TRUE(result.has_value());
    return *std::move(result);
  }
  void write(const char* name, const Paint& paint, const ExrKind& kind = xyz_exr()) {
    write_exr(dir / name, kSize, kSize, paint, kind);
  }
  TempDir dir;
};

Paint lab_paint(double l, double a, double b) {
  const Xyz white = white_of(Illuminant::kD65);
  const double fy = (l + 16) / 116;
  const auto cubed = [](double f) { return f * f * f; };
  return flat(white[0] * cubed(fy + a / 500), cubed(fy), white[2] * cubed(fy - b / 200));
}

TEST_F(CompareFiles, APublishedPairGivesItsDifference) {
  // Pair 1 and 25 of Sharma, Wu and Dalal 2005.
  write("a.exr", lab_paint(50, 2.6772, -79.7751));
  write("b.exr", lab_paint(50, 0, -82.7485));
  const Comparison c = compare("a.exr", "b.exr");
  for (const double figure : {c.color->all.mean, c.color->all.median, c.color->all.p95,
                              c.color->all.max, c.color->without_worst_percent.max}) {
    EXPECT_NEAR(figure, 2.0425, 2e-4);
  }
  write("c.exr", lab_paint(60.2574, -34.0099, 36.2677));
  write("d.exr", lab_paint(60.4626, -34.1751, 39.4387));
  EXPECT_NEAR(compare("c.exr", "d.exr").color->all.mean, 1.2644, 2e-4);
  EXPECT_FALSE(c.identical);
  EXPECT_TRUE(compare("a.exr", "a.exr").identical);
}

TEST_F(CompareFiles, TheWorstPercentIsLeftOut) {
  write("a.exr", lab_paint(50, 0, 0));
  // 0.5 % of the pixels are 10 off, 2 % are 1 off.
  write("b.exr", [](int x, int y) {
    const int i = y * kSize + x;
    return lab_paint(i < 46 ? 60 : (i < 230 ? 51 : 50), 0, 0)(0, 0);
  });
  CompareOptions options;
  options.worst_fraction = 0.03;
  const Comparison c = compare("a.exr", "b.exr", options);
  EXPECT_GT(c.color->all.max, 9);
  EXPECT_NEAR(c.color->without_worst_percent.max, 1, 0.05);
  EXPECT_NEAR(c.color->trimmed.max, 0, 1e-5);
  EXPECT_EQ(c.color->without_worst_percent.n, kSize * kSize - 92);
  EXPECT_NEAR(c.color->all.median, 0, 1e-5);
}

TEST(Figures, AreTheRanksOfTheSamples) {
  std::vector<float> values;
  for (int i = 200; i > 0; --i) values.push_back(static_cast<float>(i));
  const DifferenceFigures all = figures_of(values, 0);
  EXPECT_EQ(all.max, 200);
  EXPECT_EQ(all.p95, 190);
  EXPECT_EQ(all.median, 100.5);
  EXPECT_EQ(all.mean, 100.5);
  const DifferenceFigures trimmed = figures_of(values, 0.01);
  EXPECT_EQ(trimmed.max, 198);
  EXPECT_EQ(trimmed.n, 198);
  EXPECT_EQ(trimmed.mean, 99.5);
  std::vector<float> one{3};
  EXPECT_EQ(figures_of(one, 0).p95, 3);
  EXPECT_EQ(figures_of({}, 0).n, 0);
}

TEST_F(CompareFiles, AGainIsFittedAndAWhiteToo) {
  const auto paint = [](double r, double g, double b) {
    return [=](int x, int y) {
      const double v = 0.2 + 0.006 * x + 0.001 * y;
      return Pixel{r * v, g * v, b * v, 1};
    };
  };
  write("a.exr", paint(0.95, 1, 1.09));
  write("half.exr", paint(0.475, 0.5, 0.545));
  write("warm.exr", paint(1.1, 1, 0.7));
  EXPECT_GT(compare("a.exr", "half.exr").color->all.mean, 10);
  CompareOptions gain;
  gain.fit = Fit::kGain;
  const Comparison fitted = compare("a.exr", "half.exr", gain);
  EXPECT_NEAR(fitted.color->gain, 2, 1e-6);
  EXPECT_LT(fitted.color->all.max, 1e-3);
  EXPECT_GT(compare("a.exr", "warm.exr", gain).color->all.mean, 5);
  CompareOptions white;
  white.fit = Fit::kWhite;
  EXPECT_LT(compare("a.exr", "warm.exr", white).color->all.max, 0.01);
}

TEST_F(CompareFiles, WhitesOfCielab) {
  const Xyz d65 = white_of(Illuminant::kD65);
  write("white.exr", flat(d65[0], d65[1], d65[2]));
  write("grey.exr", flat(d65[0] / 2, d65[1] / 2, d65[2] / 2));
  CompareOptions options;
  const double expected = compare("white.exr", "grey.exr").color->all.mean;
  // A neutral stays one under every illuminant: only the lightness differs, by the same.
  for (const char* word : {"D50", "A", "B", "C", "E"}) {
    options.white = parse_lab_white(word);
    const Comparison c = compare("white.exr", "grey.exr", options);
    EXPECT_NEAR(c.color->all.mean, expected, 1e-4) << word;
    EXPECT_NEAR(c.color->bias.lab[1], 0, 1e-4) << word;
  }
  // The cast of a picture is gone against its own white.
  write("clear.exr", flat(1, 1, 1), process_exr());
  ExrKind pink;
  pink.options.chromaticities = srgb_chromaticities();
  pink.options.chromaticities->xy[3] = {0.35, 0.31};
  write("pink.exr", flat(1, 1, 1), pink);
  EXPECT_GT(compare("clear.exr", "pink.exr").color->all.mean, 5);
  options.white = LabWhite::kOwn;
  EXPECT_LT(compare("clear.exr", "pink.exr", options).color->all.mean, 1e-3);
  CompareOptions adapt;
  adapt.adapt_own_white = true;
  EXPECT_LT(compare("clear.exr", "pink.exr", adapt).color->all.mean, 1e-3);
}

TEST_F(CompareFiles, ClampsWhenAsked) {
  write("a.exr", flat(1.2, 1, 1.5));
  write("b.exr", flat(1.0, 1, 1.0));
  EXPECT_GT(compare("a.exr", "b.exr").color->all.mean, 3);
  CompareOptions clamp;
  clamp.clamp_xyz = true;
  EXPECT_LT(compare("a.exr", "b.exr", clamp).color->all.max, 1e-4);
}

TEST_F(CompareFiles, PrimariesAreConvertedAndProcessIsSaid) {
  const auto model = [](const char* primaries, OutputSpace space) {
    return make_color_model(primaries, Balance::kNeutral, space);
  };
  const Vector3 process{0.3, 0.7, 0.2};
  ExrKind kind = process_exr();
  write("process.exr", flat(process[0], process[1], process[2]), kind);
  const Vector3 xyz =
      multiply(model("cornwell-clyne-1951", OutputSpace::kXyz).output_from_process, process);
  write("xyz.exr", flat(xyz[0], xyz[1], xyz[2]));
  EXPECT_LT(compare("process.exr", "xyz.exr").color->all.max, 0.01);

  kind.options.chromaticities = model("neblette-1952", OutputSpace::kProcess).chromaticities;
  kind.options.attributes[1].second = "neblette-1952";
  write("other.exr", flat(process[0], process[1], process[2]), kind);
  const Comparison c = compare("process.exr", "other.exr");
  EXPECT_GT(c.color->all.mean, 1);
  EXPECT_TRUE(c.process_rgb);
  EXPECT_THAT(c.pairing, HasSubstr("each seen through its own primaries"));
}

TEST_F(CompareFiles, ATruthIsSeenThroughThePrimariesOfTheResult) {
  const Vector3 process{0.3, 0.7, 0.2};
  ExrKind truth = process_exr();
  truth.options.attributes.emplace_back("reseau.truth", "reseau-truth/1");
  write("truth.exr", flat(process[0], process[1], process[2]), truth);
  const ColorModel model =
      make_color_model("neblette-1952", Balance::kBrightness, OutputSpace::kSrgbLinear);
  ExrKind result;
  result.options.chromaticities = model.chromaticities;
  result.options.attributes = {{"reseau.space", "srgb-linear"},
                               {"reseau.primaries", "neblette-1952"},
                               {"reseau.balance", "brightness"}};
  const Vector3 rgb = multiply(model.output_from_process, process);
  write("result.exr", flat(rgb[0], rgb[1], rgb[2]), result);
  for (const bool swapped : {false, true}) {
    const Comparison c =
        swapped ? compare("result.exr", "truth.exr") : compare("truth.exr", "result.exr");
    EXPECT_LT(c.color->all.max, 0.01);
    EXPECT_THAT(c.pairing, HasSubstr("neblette-1952, balance brightness"));
  }
  CompareOptions scene;
  scene.layer = Layer::kScene;
  EXPECT_THROW(compare("truth.exr", "result.exr", scene), InputError);
}

TEST_F(CompareFiles, SizesCropOffsetAndBorder) {
  const auto paint = [](int x, int y) { return Pixel{0.2 + 0.005 * x, 0.2 + 0.004 * y, 0.3, 1}; };
  write_exr(dir / "a.exr", 80, 60, paint, xyz_exr());
  write_exr(
      dir / "b.exr", 90, 50, [&](int x, int y) { return paint(x - 7, y + 3); }, xyz_exr());
  EXPECT_THROW(compare("a.exr", "b.exr"), InputError);
  CompareOptions options;
  options.offset_x_px = 7;
  options.offset_y_px = -3;
  Comparison c = compare("a.exr", "b.exr", options);
  EXPECT_EQ(c.color->all.max, 0);
  EXPECT_EQ(c.area.width_px, 80);
  EXPECT_EQ(c.area.height_px, 50);
  EXPECT_EQ(c.area.y_px, 3);
  options.crop = Rect{10, 10, 20, 15};
  options.border_px = 2;
  c = compare("a.exr", "b.exr", options);
  EXPECT_EQ(c.color->all.n, 16 * 11);
  EXPECT_EQ(c.color->all.max, 0);
  options.border_px = 8;
  EXPECT_THROW(compare("a.exr", "b.exr", options), InputError);
  options = {};
  options.crop = Rect{70, 0, 11, 5};
  EXPECT_THROW(compare("a.exr", "b.exr", options), InputError);
}

TEST_F(CompareFiles, PixelsThatAreNotFiniteAreCountedAndLeftOut) {
  write("a.exr", lab_paint(50, 0, 0));
  write("b.exr", [](int x, int y) {
    Pixel p = lab_paint(50, 0, 0)(0, 0);
    if (x == 5) p[static_cast<std::size_t>(y % 3)] = y % 2 == 0 ? NAN : INFINITY;
    return p;
  });
  const Comparison c = compare("a.exr", "b.exr");
  EXPECT_EQ(c.color->n_not_finite, kSize);
  EXPECT_LT(c.color->all.max, 1e-5);
  EXPECT_FALSE(c.identical);
  EXPECT_THAT(c.warnings, Contains(HasSubstr("96 pixels are not finite")));
  write("nan.exr", flat(NAN, NAN, NAN));
  EXPECT_THROW(compare("a.exr", "nan.exr"), InputError);
  const std::string text = comparison_to_json(c, {}).dump();
  EXPECT_EQ(text.find("nan"), std::string::npos);
}

TEST_F(CompareFiles, TinyPicturesHaveOnlyWhatTheyCanHave) {
  write_exr(dir / "a.exr", 1, 1, flat(0.2, 0.3, 0.1), xyz_exr());
  write_exr(dir / "b.exr", 1, 1, flat(0.2, 0.3, 0.2), xyz_exr());
  const Comparison c = compare("a.exr", "b.exr");
  EXPECT_EQ(c.color->all.n, 1);
  EXPECT_FALSE(c.resolution || c.noise || c.shift || c.registration);
  for (const std::string& why : {c.no_resolution, c.no_noise, c.no_shift, c.no_registration}) {
    EXPECT_FALSE(why.empty());
  }
  EXPECT_FALSE(describe_comparison(c, {}).empty());
}

// Two colours beside a slanted edge, smoothed by a Gaussian.
Paint color_edge(double sigma, double shift) {
  return [=](int x, int y) {
    const double a = 8 * std::numbers::pi / 180;
    const double d = (x - 47.5) * std::cos(a) + (y - 47.5) * std::sin(a) - shift;
    const double share = 0.5 * std::erfc(-d / (sigma * std::numbers::sqrt2));
    const Vector3 green{0.2, 0.4, 0.1}, red{0.4, 0.25, 0.1};
    Pixel p{0, 0, 0, 1};
    for (std::size_t k = 0; k < 3; ++k) p[k] = green[k] + share * (red[k] - green[k]);
    return p;
  };
}

TEST_F(CompareFiles, ResolutionLossAtAColourEdgeFoundByItself) {
  write("a.exr", color_edge(0.7, 0));
  write("b.exr", color_edge(2.1, 0.5));
  CompareOptions given;
  given.edge = Rect{16, 20, 64, 60};
  for (const CompareOptions& options : {CompareOptions{}, given}) {
    const Comparison c = compare("a.exr", "b.exr", options);
    ASSERT_TRUE(c.resolution.has_value()) << c.no_resolution;
    EXPECT_NEAR(*c.resolution->b.mtf50_cy_per_px / *c.resolution->a.mtf50_cy_per_px, 1.0 / 3, 0.01);
    const double f = 0.1 * std::numbers::pi;
    ASSERT_TRUE(c.resolution->ratio[10].has_value());
    EXPECT_NEAR(*c.resolution->ratio[10], std::exp(-2 * f * f * (2.1 * 2.1 - 0.7 * 0.7)), 0.01);
    EXPECT_NEAR(c.resolution->shift_px, 0.5, 0.02);
    EXPECT_NEAR(c.resolution->b.contrast / c.resolution->a.contrast, 1, 0.01);
  }
  given.edge = Rect{90, 0, 40, 40};
  EXPECT_THROW(compare("a.exr", "b.exr", given), InputError);
  const Comparison same = compare("a.exr", "a.exr");
  EXPECT_NEAR(*same.resolution->ratio[20], 1, 1e-9);
}

TEST_F(CompareFiles, MapsAloneAreCompared) {
  const auto map = [](double shift) {
    return [shift](int x, int y) {
      return Pixel{0.12 * (x + shift) + 0.05 * y, 0.11 * y - 0.05 * (x + shift), 0, 0};
    };
  };
  ExrKind uv;
  uv.channels = {"u", "v"};
  write("a.exr", map(0), uv);
  write("b.exr", map(0.5), uv);
  const Comparison c = compare("a.exr", "b.exr");
  EXPECT_FALSE(c.color.has_value());
  ASSERT_TRUE(c.registration.has_value());
  EXPECT_NEAR(c.registration->mean_x_px, 0.5, 1e-4);
  const auto json = comparison_to_json(c, {});
  EXPECT_TRUE(json["delta_e_2000"].is_null());
  EXPECT_TRUE(json["not_available"].contains("delta_e_2000"));
  EXPECT_NEAR(json["registration"]["rms_px"].get<double>(), 0.5, 1e-4);
  // Apart from the pictures.
  write("picture.exr", lab_paint(50, 0, 0));
  CompareOptions apart;
  apart.map_a = dir / "a.exr";
  apart.map_b = dir / "b.exr";
  EXPECT_NEAR(compare("picture.exr", "picture.exr", apart).registration->rms_px, 0.5, 1e-4);
  write_exr(dir / "small.exr", 4, 4, map(0), uv);
  apart.map_b = dir / "small.exr";
  EXPECT_THROW(compare("picture.exr", "picture.exr", apart), InputError);
  EXPECT_THROW(compare("picture.exr", "a.exr"), InputError);
}

TEST_F(CompareFiles, AStopRequestEndsIt) {
  write("a.exr", lab_paint(50, 0, 0));
  std::stop_source source;
  source.request_stop();
  EXPECT_FALSE(compare_files(dir / "a.exr", dir / "a.exr", {}, source.get_token()).has_value());
}

}  // namespace
}  // namespace reseau::compare
