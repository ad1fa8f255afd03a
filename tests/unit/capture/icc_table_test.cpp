// Scans with a table (LUT) profile, whose red, green and blue depend on all three samples.
#include "capture/image/icc_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lcms2.h>
#include <tiffio.h>

#include "capture/image/icc.h"
#include "capture/image/scan_reader.h"
#include "core/color/colorimetry.h"
#include "core/color/rgb_space.h"
#include "tests/support/temp_dir.h"

namespace reseau {
namespace {

// The scanner of the profile: samples are the square roots of a mixture of the light in ProPhoto
// RGB; so the light is the mixture undone.
constexpr std::array<std::array<double, 3>, 3> kLightFromMixed = {
    {{1.2, -0.1, -0.1}, {-0.15, 1.25, -0.1}, {-0.05, -0.15, 1.2}}};

std::array<double, 3> light_of(const std::array<double, 3>& sample) {
  std::array<double, 3> light{};
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t c = 0; c < 3; ++c) light[k] += kLightFromMixed[k][c] * sample[c] * sample[c];
  }
  return light;
}

cmsInt32Number fill_table(const cmsUInt16Number in[], cmsUInt16Number out[], void* cargo) {
  const auto& xyz = *static_cast<const Matrix3*>(cargo);
  const auto light = light_of({in[0] / 65535.0, in[1] / 65535.0, in[2] / 65535.0});
  const Xyz color = multiply(xyz, Vector3{light[0], light[1], light[2]});
  for (std::size_t i = 0; i < 3; ++i) {
    // XYZ of the connection space: 8000 hexadecimal is 1.
    const double coded = std::clamp(color[i] * 32768, 0.0, 65535.0);
    out[i] = static_cast<cmsUInt16Number>(std::lround(coded));
  }
  return 1;
}

// The same as plain XYZ, which may be negative.
cmsInt32Number fill_float_table(const cmsFloat32Number in[], cmsFloat32Number out[], void* cargo) {
  const auto& xyz = *static_cast<const Matrix3*>(cargo);
  const auto light = light_of({double{in[0]}, double{in[1]}, double{in[2]}});
  const Xyz color = multiply(xyz, Vector3{light[0], light[1], light[2]});
  for (std::size_t i = 0; i < 3; ++i) out[i] = static_cast<cmsFloat32Number>(color[i]);
  return 1;
}

std::vector<std::byte> table_profile(const char* space = "RGB") {
  cmsHPROFILE profile = cmsCreateProfilePlaceholder(nullptr);
  cmsSetProfileVersion(profile, 4.3);
  cmsSetDeviceClass(profile, cmsSigInputClass);
  cmsSetColorSpace(profile, space == std::string("RGB") ? cmsSigRgbData : cmsSigLabData);
  cmsSetPCS(profile, cmsSigXYZData);
  Matrix3 xyz = xyz_from_rgb(rgb_space_chromaticities("prophoto"));
  cmsPipeline* lut = cmsPipelineAlloc(nullptr, 3, 3);
  cmsStage* clut = cmsStageAllocCLut16bit(nullptr, 17, 3, 3, nullptr);
  cmsStageSampleCLut16bit(clut, fill_table, &xyz, 0);
  // A table is kept between curves, even where these do nothing.
  cmsPipelineInsertStage(lut, cmsAT_END, cmsStageAllocToneCurves(nullptr, 3, nullptr));
  cmsPipelineInsertStage(lut, cmsAT_END, clut);
  cmsPipelineInsertStage(lut, cmsAT_END, cmsStageAllocToneCurves(nullptr, 3, nullptr));
  // A reader that does not know floating tables finds this coarser one.
  EXPECT_TRUE(cmsWriteTag(profile, cmsSigAToB0Tag, lut));
  EXPECT_TRUE(cmsWriteTag(profile, cmsSigAToB1Tag, lut));
  cmsPipeline* exact = cmsPipelineAlloc(nullptr, 3, 3);
  cmsStage* fine = cmsStageAllocCLutFloat(nullptr, 49, 3, 3, nullptr);
  cmsStageSampleCLutFloat(fine, fill_float_table, &xyz, 0);
  cmsPipelineInsertStage(exact, cmsAT_BEGIN, fine);
  EXPECT_TRUE(cmsWriteTag(profile, cmsSigDToB1Tag, exact));
  cmsUInt32Number size = 0;
  cmsSaveProfileToMem(profile, nullptr, &size);
  std::vector<std::byte> bytes(size);
  EXPECT_TRUE(cmsSaveProfileToMem(profile, bytes.data(), &size));
  cmsPipelineFree(lut);
  cmsPipelineFree(exact);
  cmsCloseProfile(profile);
  return bytes;
}

// 0.3 to 0.9 in each channel, in an order that repeats no triple; 4th: infrared.
std::uint16_t sample(std::size_t i, std::size_t channel) {
  constexpr std::array<std::size_t, 4> kStride = {7, 11, 13, 3};
  return static_cast<std::uint16_t>(20000 + (i * kStride[channel] * 97) % 39000);
}

constexpr int kWidth = 37, kLines = 21;

void write_scan(const std::filesystem::path& path, const std::vector<std::byte>& icc,
                std::uint16_t compression) {
  TIFF* tiff = TIFFOpen(path.c_str(), "w");
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, kWidth);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, kLines);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 16);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 4);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_RGB);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, compression);
  const std::uint16_t extra = 0;
  TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, 1, &extra);
  TIFFSetField(tiff, TIFFTAG_ICCPROFILE, static_cast<std::uint32_t>(icc.size()), icc.data());
  std::vector<std::uint16_t> row(std::size_t{4} * kWidth);
  for (std::size_t y = 0; y < kLines; ++y) {
    for (std::size_t x = 0; x < kWidth; ++x) {
      for (std::size_t c = 0; c < 4; ++c) row[4 * x + c] = sample(y * kWidth + x, c);
    }
    ASSERT_EQ(TIFFWriteScanline(tiff, row.data(), static_cast<std::uint32_t>(y), 0), 1);
  }
  TIFFClose(tiff);
}

TEST(IccTable, UndoesWhatNoCurvePerChannelCan) {
  const test::TempDir dir;
  // Read on demand, and decoded into memory.
  for (const std::uint16_t compression :
       {std::uint16_t{COMPRESSION_NONE}, std::uint16_t{COMPRESSION_LZW}}) {
    const auto path = dir / (compression == COMPRESSION_NONE ? "plain.tif" : "lzw.tif");
    write_scan(path, table_profile(), compression);
    const Scan scan = read_scan(path);
    EXPECT_THAT(scan.notes, testing::Contains(testing::HasSubstr("is a table")));
    const LineFormat& format = scan.source->format();
    std::vector<std::uint16_t> lines(format.samples_per_line() * kLines);
    scan.source->read(0, kLines, lines);
    double worst = 0;
    for (std::size_t y = 0; y < kLines; ++y) {
      for (std::size_t x = 0; x < kWidth; ++x) {
        const std::size_t i = y * kWidth + x;
        const auto light =
            light_of({sample(i, 0) / 65535.0, sample(i, 1) / 65535.0, sample(i, 2) / 65535.0});
        const auto at = [&](std::size_t c) { return lines[y * 4 * kWidth + c * kWidth + x]; };
        for (std::size_t c = 0; c < 3; ++c) {
          const double clipped = std::clamp(light[c], 0.0, 1.0);
          const double got = double{scan.tone.table(static_cast<int>(c))[at(c)]};
          worst = std::max(worst, std::abs(got - clipped));
        }
        EXPECT_EQ(at(3), sample(i, 3));
      }
    }
    // 49 steps of a parabola between the points of the table, and its 16 bits.
    EXPECT_LT(worst, 4e-4);
    EXPECT_FLOAT_EQ(scan.tone.table(3)[20000], 20000 / 65535.0F);
  }
}

TEST(IccTable, GammaOverridesIt) {
  const test::TempDir dir;
  write_scan(dir / "scan.tif", table_profile(), COMPRESSION_NONE);
  ReadScanOptions options;
  options.gamma = 1;
  const Scan scan = read_scan(dir / "scan.tif", options);
  std::vector<std::uint16_t> line(scan.source->format().samples_per_line());
  scan.source->read(0, 1, line);
  EXPECT_EQ(line[5], sample(5, 0));
  EXPECT_THAT(scan.notes, testing::ElementsAre(testing::HasSubstr("is not used")));
}

TEST(IccTable, IsNotMadeOfOtherProfiles) {
  EXPECT_EQ(IccTable::open(srgb_icc()), nullptr);
  EXPECT_EQ(IccTable::open({}), nullptr);
  EXPECT_EQ(IccTable::open(table_profile("Lab")), nullptr);
  auto cut = table_profile();
  cut.resize(cut.size() / 2);
  // Whatever lcms2 makes of it: no crash, and a scan with it is read.
  EXPECT_FALSE(tone_of_icc(cut).note.empty());
}

TEST(IccTable, CountsWhatLiesOutside) {
  const auto table = IccTable::open(table_profile());
  ASSERT_NE(table, nullptr);
  LineFormat format;
  format.width_px = 2;
  format.n_lines = 1;
  format.channels = {Channel::kRed, Channel::kGreen, Channel::kBlue};
  // The first pixel is inside; the second, nearly pure red, has negative green and blue.
  std::vector<std::uint16_t> samples = {40000, 40000, 40000, 0, 40000, 0};
  EXPECT_EQ(table->to_linear_light(format, samples), 2u);
  EXPECT_EQ(samples[3], 0);
  EXPECT_EQ(samples[5], 0);
}

}  // namespace
}  // namespace reseau
