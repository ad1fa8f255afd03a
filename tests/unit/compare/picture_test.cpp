// The same colour through every format and encoding is the same XYZ.
#include "capture/compare/picture.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/image/icc.h"
#include "core/base/error.h"
#include "core/color/rgb_space.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/compare/picture_files.h"

namespace reseau::compare {
namespace {

using reseau::test::TempDir;
using reseau::test::write_bytes;
using ::testing::HasSubstr;

constexpr int kWidth = 37, kHeight = 21;
const Rgb kLinear{0.35, 0.08, 0.61};

Paint encoded() {
  return flat(srgb_encode(kLinear[0]), srgb_encode(kLinear[1]), srgb_encode(kLinear[2]));
}
Paint linear() { return flat(kLinear[0], kLinear[1], kLinear[2]); }

// XYZ of every pixel must be the same; returns that of the last.
Xyz only_xyz(const std::filesystem::path& path, const PictureChoice& choice = {}) {
  const auto picture = open_picture(read_picture_header(path), choice);
  EXPECT_EQ(picture->header().width_px, kWidth);
  EXPECT_EQ(picture->header().height_px, kHeight);
  std::vector<float> samples(3 * kWidth * kHeight);
  picture->read(0, kHeight, samples);
  picture->to_xyz(samples, samples);
  for (std::size_t i = 3; i < samples.size(); ++i) EXPECT_EQ(samples[i], samples[i - 3]);
  // Any row once more: formats that can only be read forwards have to begin again.
  std::vector<float> row(3 * kWidth);
  picture->read(2, 1, row);
  picture->to_xyz(row, row);
  EXPECT_EQ(row[0], samples[0]);
  return {double{samples[0]}, double{samples[1]}, double{samples[2]}};
}

class PictureFormats : public ::testing::Test {
 protected:
  void expect_same(const std::filesystem::path& path, double tolerance,
                   const PictureChoice& choice = {}) {
    const Xyz expected = multiply(inverse(srgb_from_xyz_d65()), kLinear);
    const Xyz got = only_xyz(path, choice);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(got[k], expected[k], tolerance) << path << k;
  }
  TempDir dir;
};

TEST_F(PictureFormats, Exr) {
  ExrKind kind;
  kind.options.chromaticities = srgb_chromaticities();
  write_exr(dir / "srgb.exr", kWidth, kHeight, linear(), kind);
  expect_same(dir / "srgb.exr", 1e-6);
  write_exr(dir / "undeclared.exr", kWidth, kHeight, linear());
  expect_same(dir / "undeclared.exr", 1e-6);
  const Xyz xyz = multiply(inverse(srgb_from_xyz_d65()), kLinear);
  write_exr(dir / "xyz.exr", kWidth, kHeight, flat(xyz[0], xyz[1], xyz[2]), xyz_exr());
  expect_same(dir / "xyz.exr", 1e-6);
}

TEST_F(PictureFormats, Png) {
  write_png(dir / "8.png", kWidth, kHeight, encoded());
  expect_same(dir / "8.png", 2e-3);
  write_png(dir / "16.png", kWidth, kHeight, encoded(), {.sixteen_bit = true});
  expect_same(dir / "16.png", 1e-5);
  write_png(dir / "untagged.png", kWidth, kHeight, encoded(),
            {.sixteen_bit = true, .srgb_chunk = false});
  expect_same(dir / "untagged.png", 1e-5);
  write_png(dir / "alpha.png", kWidth, kHeight, encoded(), {.sixteen_bit = true, .alpha = true});
  expect_same(dir / "alpha.png", 1e-5);
  write_png(dir / "linear.png", kWidth, kHeight, linear(),
            {.sixteen_bit = true, .srgb_chunk = false, .gamma = 1});
  expect_same(dir / "linear.png", 2e-5);
  write_png(dir / "plain.png", kWidth, kHeight, linear(),
            {.sixteen_bit = true, .srgb_chunk = false});
  expect_same(dir / "plain.png", 2e-5, {.scene_layer = false, .untagged_is_linear = true});
}

TEST_F(PictureFormats, Tiff) {
  write_tiff(dir / "icc.tif", kWidth, kHeight, encoded(), {.icc = srgb_icc()});
  expect_same(dir / "icc.tif", 2e-4);
  write_tiff(dir / "linear.tif", kWidth, kHeight, linear(), {.icc = linear_scanner_icc()});
  expect_same(dir / "linear.tif", 2e-4);
  write_tiff(dir / "8.tif", kWidth, kHeight, encoded(), {.bits = 8});
  expect_same(dir / "8.tif", 2e-3);
  write_tiff(dir / "four.tif", kWidth, kHeight, encoded(), {.samples = 4});
  expect_same(dir / "four.tif", 1e-5);
  write_tiff(dir / "float.tif", kWidth, kHeight, linear(), {.bits = 32});
  expect_same(dir / "float.tif", 1e-6);
  write_tiff(dir / "planar.tif", kWidth, kHeight, encoded(), {.planar = true});
  expect_same(dir / "planar.tif", 1e-5);
  write_tiff(dir / "tiled.tif", kWidth, kHeight, encoded(), {.tiled = true});
  expect_same(dir / "tiled.tif", 1e-5);
  write_tiff(dir / "deflate.tif", kWidth, kHeight, encoded(), {.deflate = true});
  expect_same(dir / "deflate.tif", 1e-5);
}

TEST_F(PictureFormats, DamagedProfileIsSaidAndNotUsed) {
  write_tiff(dir / "bad.tif", kWidth, kHeight, encoded(),
             {.icc = std::vector<std::byte>(200, std::byte{7})});
  expect_same(dir / "bad.tif", 1e-5);
  const auto picture = open_picture(read_picture_header(dir / "bad.tif"));
  ASSERT_FALSE(picture->notes().empty());
  EXPECT_THAT(picture->notes()[0], HasSubstr("damaged"));
}

TEST_F(PictureFormats, GreyIsNeutral) {
  write_tiff(dir / "grey.tif", kWidth, kHeight, flat(0.5, 0, 0), {.bits = 32, .samples = 1});
  ExrKind grey;
  grey.channels = {"Y"};
  write_exr(dir / "grey.exr", kWidth, kHeight, flat(0.5, 0, 0), grey);
  const Xyz d65 = white_of(Illuminant::kD65);
  for (const char* name : {"grey.tif", "grey.exr"}) {
    const Xyz xyz = only_xyz(dir / name);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(xyz[k], 0.5 * d65[k], 1e-6) << name;
  }
}

TEST_F(PictureFormats, TransparentPixelsAreNotFinite) {
  write_png(dir / "a.png", kWidth, kHeight,
            [](int x, int) {
              return Pixel{1, 1, 1, x == 3 ? 0.0 : 1.0};
            },
            {.alpha = true});
  ExrKind rgba;
  rgba.channels = {"R", "G", "B", "A"};
  write_exr(
      dir / "a.exr", kWidth, kHeight,
      [](int x, int) {
        return Pixel{1, 1, 1, x == 3 ? 0.0 : 1.0};
      },
      rgba);
  for (const char* name : {"a.png", "a.exr"}) {
    const auto picture = open_picture(read_picture_header(dir / name));
    std::vector<float> row(3 * kWidth);
    picture->read(0, 1, row);
    EXPECT_TRUE(std::isnan(row[9])) << name;
    EXPECT_EQ(row[12], 1) << name;
  }
}

TEST_F(PictureFormats, RefusesWithASentence) {
  write_bytes(dir / "words.png", "This is no picture.");
  write_bytes(dir / "empty.tif", "");
  std::filesystem::create_directory(dir / "folder.exr");
  write_png(dir / "whole.png", kWidth, kHeight, encoded(), {.sixteen_bit = true});
  const std::string bytes = reseau::test::file_bytes(dir / "whole.png");
  write_bytes(dir / "cut.png", bytes.substr(0, bytes.size() - 40));
  ExrKind odd;
  odd.channels = {"depth"};
  write_exr(dir / "depth.exr", kWidth, kHeight, encoded(), odd);
  for (const char* name :
       {"words.png", "empty.tif", "folder.exr", "cut.png", "depth.exr", "missing.exr"}) {
    try {
      static_cast<void>(open_picture(read_picture_header(dir / name)));
      ADD_FAILURE() << name;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(name));
    }
  }
}

}  // namespace
}  // namespace reseau::compare
