// Other colours for a picture that is there.
#include "capture/session/recolor.h"

#include <cmath>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/color/color_record.h"
#include "core/base/error.h"
#include "tests/support/temp_dir.h"

namespace reseau {
namespace {

constexpr int kWidth = 61, kHeight = 600;  // many bands of the recolouring, the last one short

std::vector<float> process_pixels() {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> intensity(-0.1F, 1.2F);
  std::vector<float> rgb(std::size_t{3} * kWidth * kHeight);
  for (float& v : rgb) v = intensity(random);
  rgb[10] = std::numeric_limits<float>::infinity();
  return rgb;
}

// A picture of these element intensities in the colours of a recipe.
void write_picture(const std::filesystem::path& path, const ColorRecipe& recipe) {
  ExrOptions options;
  declare_color(recipe, options);
  std::vector<float> rgb = process_pixels();
  const Matrix3 m = make_color_model(recipe).output_from_process;
  for (std::size_t i = 0; i < rgb.size(); i += 3) {
    const Vector3 out =
        multiply(m, Vector3{double{rgb[i]}, double{rgb[i + 1]}, double{rgb[i + 2]}});
    for (std::size_t c = 0; c < 3; ++c) rgb[i + c] = static_cast<float>(out[c]);
  }
  FloatImageWriter writer(path, kWidth, kHeight, {"R", "G", "B"}, options);
  writer.rows(0, kHeight, rgb);
  writer.finish();
}

ColorRecipe recipe_of(const char* set, Balance balance, OutputSpace space) {
  ColorRecipe recipe;
  recipe.primaries = find_primary_set(set);
  recipe.balance = balance;
  recipe.space = space;
  return recipe;
}

class RecolorTest : public ::testing::Test {
 protected:
  Recolored run(const ColorRecipe& color, const std::string& name, int n_threads = 0) {
    options.source = dir / "source.exr";
    options.exr = dir / name;
    options.color = color;
    options.n_threads = n_threads;
    return recolor(options, {}, {});
  }
  test::TempDir dir;
  RecolorOptions options;
};

TEST_F(RecolorTest, GivesWhatTheNewRecipeWouldHaveGiven) {
  write_picture(dir / "source.exr",
                recipe_of("cornwell-clyne-1951", Balance::kNeutral, OutputSpace::kSrgbLinear));
  const ColorRecipe wanted =
      recipe_of("neblette-1952", Balance::kBrightness, OutputSpace::kAcesAp0);
  const Recolored done = run(wanted, "new.exr");
  ASSERT_TRUE(done.written);
  const FloatImage image = read_exr(dir / "new.exr");
  const Matrix3 m = make_color_model(wanted).output_from_process;
  const std::vector<float> process = process_pixels();
  for (std::size_t i = 0; i < process.size(); i += 3) {
    const Vector3 p{double{process[i]}, double{process[i + 1]}, double{process[i + 2]}};
    if (!std::isfinite(p[1])) continue;
    const Vector3 out = multiply(m, p);
    for (std::size_t c = 0; c < 3; ++c) ASSERT_NEAR(image.samples[i + c], out[c], 2e-5) << i;
  }
  const ExrReader reader(dir / "new.exr");
  EXPECT_EQ(reader.attribute("reseau.primaries"), "neblette-1952");
  EXPECT_NEAR(reader.chromaticities()->xy[0][0], 0.7347, 1e-6);
  EXPECT_NEAR(reader.chromaticities()->xy[2][1], -0.077, 1e-6);
}

TEST_F(RecolorTest, BackAgainIsTheSamePicture) {
  const ColorRecipe first =
      recipe_of("cornwell-clyne-1951", Balance::kNeutral, OutputSpace::kRec2020);
  write_picture(dir / "source.exr", first);
  static_cast<void>(
      run(recipe_of("collins-giles-1952", Balance::kBradford, OutputSpace::kXyz), "there.exr"));
  options.source = dir / "there.exr";
  options.exr = dir / "back.exr";
  options.color = first;
  static_cast<void>(recolor(options, {}, {}));
  const FloatImage a = read_exr(dir / "source.exr"), b = read_exr(dir / "back.exr");
  for (std::size_t i = 0; i < a.samples.size(); ++i) {
    if (!std::isfinite(b.samples[i])) continue;
    ASSERT_NEAR(a.samples[i], b.samples[i], 5e-6) << i;
  }
}

TEST_F(RecolorTest, ThreadsDoNotChangeAByte) {
  write_picture(dir / "source.exr", ColorRecipe{});
  const ColorRecipe wanted = recipe_of("neblette-1952", Balance::kNeutral, OutputSpace::kDisplayP3);
  static_cast<void>(run(wanted, "one.exr", 1));
  static_cast<void>(run(wanted, "two.exr", 2));
  EXPECT_TRUE(test::file_bytes(dir / "one.exr") == test::file_bytes(dir / "two.exr"));
}

TEST_F(RecolorTest, MakesAnAreaNeutral) {
  write_picture(dir / "source.exr", ColorRecipe{});
  options.neutral = parse_neutral_area("5,300,20,100");
  const Recolored done =
      run(recipe_of("cornwell-clyne-1951", Balance::kNeutral, OutputSpace::kProcess), "new.exr");
  const FloatImage image = read_exr(dir / "new.exr");
  AreaMean mean(*options.neutral);
  mean.begin(kWidth, kHeight);
  mean.rows(0, kHeight, image.samples);
  EXPECT_NEAR(mean.mean()[0], mean.mean()[1], 1e-6);
  EXPECT_NEAR(mean.mean()[2], mean.mean()[1], 1e-6);
  EXPECT_NE(done.color.white_balance, (Vector3{1, 1, 1}));
  // The file tells its factors, so that they can be taken off again.
  options.source = dir / "new.exr";
  options.exr = dir / "again.exr";
  options.neutral.reset();
  static_cast<void>(recolor(options, {}, {}));
  const FloatImage again = read_exr(dir / "again.exr");
  const std::vector<float> process = process_pixels();
  for (std::size_t i = 300; i < process.size(); ++i) {
    ASSERT_NEAR(again.samples[i], process[i], 5e-6);
  }
}

TEST_F(RecolorTest, RefusesAForeignPictureAndATakenName) {
  FloatImageWriter writer(dir / "source.exr", 4, 4, {"R", "G", "B"}, {});
  writer.rows(0, 4, std::vector<float>(48, 0.5F));
  writer.finish();
  EXPECT_THROW(static_cast<void>(run(ColorRecipe{}, "new.exr")), InputError);
  EXPECT_THAT(test::names_in(dir.path()), testing::ElementsAre("source.exr"));
  std::filesystem::remove(dir / "source.exr");
  write_picture(dir / "source.exr", ColorRecipe{});
  test::write_bytes(dir / "taken.exr", "mine");
  EXPECT_THROW(static_cast<void>(run(ColorRecipe{}, "taken.exr")), InputError);
  EXPECT_EQ(test::file_bytes(dir / "taken.exr"), "mine");
}

TEST_F(RecolorTest, AStopLeavesNothing) {
  write_picture(dir / "source.exr", ColorRecipe{});
  std::stop_source stop;
  stop.request_stop();
  options.source = dir / "source.exr";
  options.exr = dir / "new.exr";
  EXPECT_FALSE(recolor(options, {}, stop.get_token()).written);
  EXPECT_THAT(test::names_in(dir.path()), testing::ElementsAre("source.exr"));
}

}  // namespace
}  // namespace reseau
