// Image files as scenes. Skipped where the module with OpenImageIO was not built.
#include <cmath>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "drivers/sim/film/picture_file.h"
#include "drivers/sim/simulate.h"
#include "tests/support/temp_dir.h"

namespace reseau::sim {
namespace {

using ::testing::HasSubstr;

class PictureScene : public ::testing::Test {
 protected:
  void SetUp() override {
    try {
      (void)read_scene_picture(grey_tiles("probe.ppm"));
    } catch (const InputError& e) {
      if (std::string(e.what()).find("OpenImageIO") != std::string::npos) GTEST_SKIP() << e.what();
      throw;
    }
  }
  // 2 x 1: black and the given byte, or 8 x 4 of it.
  std::string grey_tiles(const std::string& name, int width = 8, int height = 4, int byte = 128) {
    const std::string path = dir_ / name;
    std::ofstream out(path, std::ios::binary);
    out << "P6\n" << width << " " << height << "\n255\n";
    for (int i = 0; i < width * height; ++i) {
      out.put(static_cast<char>(byte)).put(0).put(static_cast<char>(255));
    }
    return path;
  }
  static std::string refusal(const std::string& name) {
    try {
      (void)FilmTruth(parse_sim_spec(name).film, {.width_px = 10, .n_lines = 10});
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  }
  test::TempDir dir_;
};

TEST_F(PictureScene, IsLinearLight) {
  const SceneRaster raster = read_scene_picture(grey_tiles("a.ppm"));
  EXPECT_EQ(raster.width_px, 8);
  EXPECT_EQ(raster.height_px, 4);
  // A PNM is Rec. 709.
  EXPECT_NEAR(raster.rgb[0], std::pow((128 / 255.0 + 0.099) / 1.099, 1 / 0.45), 1e-5);
  EXPECT_EQ(raster.rgb[1], 0);
  EXPECT_NEAR(raster.rgb[2], 1, 1e-6);
}

TEST_F(PictureScene, IsWhatTheFilmShows) {
  const std::string path = grey_tiles("a.ppm");
  for (const std::string key : {"scene=", "image=", "scene=image&image="}) {
    const SimSpec spec =
        parse_sim_spec("ls5000?width_px=64&height_px=32&border_px=0&noise=0&" + key + path);
    const auto rgb = simulate_frame(spec).truth.process_rgb(30, 15);
    EXPECT_NEAR(rgb[0], std::pow((128 / 255.0 + 0.099) / 1.099, 1 / 0.45), 1e-5) << key;
    EXPECT_NEAR(rgb[1], 0, 1e-6);
  }
}

TEST_F(PictureScene, RefusalsAreSentences) {
  EXPECT_THAT(refusal("ls5000?image=" + (dir_ / "no.jpg").string()), HasSubstr("no.jpg"));
  EXPECT_THAT(refusal("ls5000?scene=image"), HasSubstr("image=FILE"));
  std::ofstream(dir_ / "text.png") << "not a picture";
  EXPECT_THAT(refusal("ls5000?image=" + (dir_ / "text.png").string()), HasSubstr("text.png"));
  EXPECT_THAT(refusal("ls5000?scene=flowers"), HasSubstr("flowers"));
}

}  // namespace
}  // namespace reseau::sim
