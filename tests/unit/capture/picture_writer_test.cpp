#include "capture/image/picture_writer.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <lcms2.h>
#include <png.h>
#include <tiffio.h>

#include "capture/image/icc.h"
#include "capture/image/view_encoding.h"
#include "core/base/error.h"
#include "tests/support/temp_dir.h"

namespace reseau {
namespace {

using test::file_bytes;
using test::names_in;
using test::TempDir;

constexpr int kWidth = 50, kHeight = 130;

// A ramp of luminance to 4.0 with some pixels outside sRGB.
std::vector<float> ramp() {
  std::vector<float> rgb;
  for (int i = 0; i < kWidth * kHeight; ++i) {
    const float v = 4.0F * static_cast<float>(i) / (kWidth * kHeight - 1);
    rgb.insert(rgb.end(), {v, 0.5F * v, i % 100 == 7 ? -1.0F : 0.25F * v});
  }
  return rgb;
}

PictureResult write_picture(PictureOptions options, int rows_at_once) {
  const auto rgb = ramp();
  PictureWriter writer(std::move(options));
  writer.begin(kWidth, kHeight);
  for (int y = 0; y < kHeight; y += rows_at_once) {
    const int n = std::min(rows_at_once, kHeight - y);
    writer.rows(y, n,
                std::span(rgb).subspan(static_cast<std::size_t>(y) * kWidth * 3,
                                       static_cast<std::size_t>(n) * kWidth * 3));
  }
  writer.end();
  return writer.result();
}

std::vector<std::uint16_t> read_tiff16(const std::filesystem::path& path) {
  TIFF* tiff = TIFFOpen(path.c_str(), "r");
  std::vector<std::uint16_t> out(static_cast<std::size_t>(kWidth) * kHeight * 3);
  if (tiff == nullptr) return {};
  for (std::uint32_t y = 0; y < kHeight; ++y) {
    if (TIFFReadScanline(tiff, out.data() + y * kWidth * 3, y, 0) != 1) out.clear();
  }
  TIFFClose(tiff);
  return out;
}

std::vector<std::uint8_t> read_png8(const std::filesystem::path& path) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&image, path.c_str()) == 0) return {};
  image.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> out(PNG_IMAGE_SIZE(image));
  if (png_image_finish_read(&image, nullptr, out.data(), 0, nullptr) == 0) return {};
  return out;
}

double srgb(double linear) {
  const double x = std::clamp(linear, 0.0, 1.0);
  return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
}

PictureOptions all_outputs(const TempDir& dir, const std::string& name) {
  PictureOptions options;
  options.exr = dir / (name + ".exr");
  options.tiff = dir / (name + ".tif");
  options.png = dir / (name + ".png");
  options.dpi = 4000;
  return options;
}

TEST(PictureWriter, ViewCopiesAreTheSrgbEncodingOfThePicture) {
  const TempDir dir;
  const auto options = all_outputs(dir, "a");
  const auto result = write_picture(options, 9);
  EXPECT_EQ(read_exr(options.exr).samples, ramp());
  EXPECT_EQ(names_in(dir.path()), (std::vector<std::string>{"a.exr", "a.png", "a.tif"}));

  const auto rgb = ramp();
  const auto deep = read_tiff16(options.tiff);
  const auto shallow = read_png8(options.png);
  ASSERT_EQ(deep.size(), rgb.size());
  ASSERT_EQ(shallow.size(), rgb.size());
  double worst16 = 0, worst8 = 0;
  for (std::size_t i = 0; i < rgb.size(); ++i) {
    const double v = srgb(static_cast<double>(rgb[i]) * result.exposure);
    worst16 = std::max(worst16, std::abs(v * 65535 - deep[i]));
    worst8 = std::max(worst8, std::abs(v * 255 - shallow[i]));
  }
  EXPECT_LT(worst16, 0.55);  // rounding, and float arithmetic
  EXPECT_LT(worst8, 0.51);
  int n_clipped = 0;
  for (std::size_t i = 0; i < rgb.size(); i += 3) {
    bool clipped = false;
    for (std::size_t c = 0; c < 3; ++c) {
      const double v = static_cast<double>(rgb[i + c]) * result.exposure;
      clipped |= v < -0.5 / 255 / 12.92 || v > std::pow((1 + 0.5 / 255 + 0.055) / 1.055, 2.4);
    }
    n_clipped += clipped ? 1 : 0;
  }
  EXPECT_GT(n_clipped, 65);
  EXPECT_NEAR(result.clipped_fraction * kWidth * kHeight, n_clipped, 1.5);
}

TEST(PictureWriter, ExposureBringsThe995thPercentileToWhite) {
  const TempDir dir;
  PictureOptions options;
  options.exr = dir / "a.exr";
  const auto result = write_picture(options, 130);
  // Luminance of the ramp without the pixels that are out of gamut.
  const double expected = 4 * 0.995 * (0.2126 + 0.5 * 0.7152 + 0.25 * 0.0722);
  EXPECT_NEAR(result.luminance_p995, expected, 0.01 * expected);
  EXPECT_DOUBLE_EQ(result.exposure, 1 / result.luminance_p995);
  options.exr = dir / "b.exr";
  options.exposure = 0.7;
  EXPECT_EQ(write_picture(options, 130).exposure, 0.7);
  options.exposure = -1;
  EXPECT_THROW(PictureWriter{options}, InputError);
}

TEST(PictureWriter, SamePictureSameBytes) {
  const TempDir dir;
  write_picture(all_outputs(dir, "a"), 1);
  write_picture(all_outputs(dir, "b"), 64);
  for (const std::string extension : {".exr", ".tif", ".png"}) {
    EXPECT_EQ(file_bytes(dir / ("a" + extension)), file_bytes(dir / ("b" + extension)))
        << extension;
  }
}

TEST(PictureWriter, TakenViewNameIsFoundBeforeTheWork) {
  const TempDir dir;
  const auto options = all_outputs(dir, "a");
  test::write_bytes(options.png, "mine");
  PictureWriter writer(options);
  EXPECT_THROW(writer.begin(kWidth, kHeight), InputError);
  EXPECT_EQ(file_bytes(options.png), "mine");
}

TEST(PictureWriter, BlackAndBrokenPicturesStayWhatTheyAre) {
  const TempDir dir;
  auto options = all_outputs(dir, "a");
  options.exr_options.existing = Existing::kReplace;
  for (const float value : {0.0F, -1.0F, std::numeric_limits<float>::quiet_NaN(),
                            std::numeric_limits<float>::infinity()}) {
    PictureWriter writer(options);
    writer.begin(4, 4);
    writer.rows(0, 4, std::vector<float>(48, value));
    writer.end();
    EXPECT_EQ(writer.result().exposure, 1.0);
  }
}

TEST(ViewEncoding, MatrixIsAppliedBeforeTheCurve) {
  const ViewEncoder encoder({0, 1, 0, 0, 0, 1, 1, 0, 0}, 2.0);
  std::vector<std::uint16_t> out(3);
  EXPECT_EQ(encoder.encode(std::vector<float>{0.1F, 0.2F, 0.3F}, out), 0U);
  EXPECT_NEAR(out[0], srgb(0.4) * 65535, 1);
  EXPECT_NEAR(out[1], srgb(0.6) * 65535, 1);
  EXPECT_NEAR(out[2], srgb(0.2) * 65535, 1);
  EXPECT_EQ(encoder.encode(std::vector<float>{0.1F, -0.2F, 0.3F}, out), 1U);
}

TEST(ViewEncoding, CurveIsExactTo16BitsEverywhere) {
  const ViewEncoder encoder({1, 0, 0, 0, 1, 0, 0, 0, 1}, 1.0);
  std::vector<std::uint16_t> out(3);
  double worst = 0;
  for (double x = 1e-7; x < 1; x *= 1.0007) {
    const auto v = static_cast<float>(x);
    (void)encoder.encode(std::vector<float>{v, v, v}, out);
    worst = std::max(worst, std::abs(srgb(static_cast<double>(v)) * 65535 - out[0]));
  }
  EXPECT_LT(worst, 0.52);
}

TEST(Icc, ProfilesAreReproducibleAndDated) {
  for (const auto& make : {linear_scanner_icc, srgb_icc}) {
    const auto icc = make();
    EXPECT_EQ(icc, make());
    cmsHPROFILE profile =
        cmsOpenProfileFromMem(icc.data(), static_cast<cmsUInt32Number>(icc.size()));
    ASSERT_NE(profile, nullptr);
    tm date{};
    cmsGetHeaderCreationDateTime(profile, &date);
    EXPECT_EQ(date.tm_year, 126);
    EXPECT_EQ(date.tm_mon, 0);
    std::array<cmsUInt8Number, 16> id{}, computed{};
    cmsGetHeaderProfileID(profile, id.data());
    EXPECT_NE(id, computed);
    cmsMD5computeID(profile);
    cmsGetHeaderProfileID(profile, computed.data());
    EXPECT_EQ(id, computed);
    EXPECT_TRUE(cmsIsMatrixShaper(profile));
    cmsCloseProfile(profile);
  }
  EXPECT_TRUE(tone_of_icc(linear_scanner_icc()).linear);
  EXPECT_FALSE(tone_of_icc(srgb_icc()).linear);
}

TEST(Icc, DamagedAndForeignProfilesAreTakenAsLinear) {
  auto damaged = srgb_icc();
  damaged.resize(100);
  EXPECT_TRUE(tone_of_icc(damaged).linear);
  EXPECT_NE(tone_of_icc(damaged).note.find("damaged"), std::string::npos);
  cmsHPROFILE lab = cmsCreateLab4Profile(nullptr);
  cmsUInt32Number size = 0;
  cmsSaveProfileToMem(lab, nullptr, &size);
  std::vector<std::byte> bytes(size);
  cmsSaveProfileToMem(lab, bytes.data(), &size);
  cmsCloseProfile(lab);
  EXPECT_NE(tone_of_icc(bytes).note.find("not one of RGB"), std::string::npos);
}

}  // namespace
}  // namespace reseau
