#include "capture/image/scan_reader.h"

#include <cmath>
#include <cstring>
#include <system_error>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <tiffio.h>
#include <unistd.h>

#include "capture/image/icc.h"
#include "capture/store/master_writer.h"
#include "core/base/error.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/capture/scan_fixture.h"

namespace reseau {
namespace {

using test::file_bytes;
using test::sample_at;
using test::TempDir;
using test::write_bytes;

// How a foreign TIFF is laid out.
struct Kind {
  std::string name;
  int bits = 16;
  int samples = 4;
  bool planar = false;
  bool tiled = false;
  int compression = COMPRESSION_NONE;
  bool floating = false;
  const char* mode = "w";
};

constexpr int kWidth = 37, kHeight = 23;

std::uint16_t expected_sample(const Kind& kind, int y, int c, int x) {
  const auto v = sample_at(y, c, x);
  return kind.bits == 8 ? static_cast<std::uint16_t>((v >> 8) * 257) : v;
}

void put(const Kind& kind, std::vector<std::uint8_t>& out, std::size_t index, std::uint16_t v) {
  if (kind.bits == 8) {
    out[index] = static_cast<std::uint8_t>(v >> 8);
  } else if (kind.bits == 16) {
    std::memcpy(&out[index * 2], &v, 2);
  } else {
    const float f = static_cast<float>(v) / 65535.0F;
    std::memcpy(&out[index * 4], &f, 4);
  }
}

void set_tags(TIFF* tiff, const Kind& kind, int samples) {
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, kWidth);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, kHeight);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, samples);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, kind.bits);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, samples >= 3 ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG,
               kind.planar ? PLANARCONFIG_SEPARATE : PLANARCONFIG_CONTIG);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, kind.compression);
  TIFFSetField(tiff, TIFFTAG_XRESOLUTION, 1574.8031F);
  TIFFSetField(tiff, TIFFTAG_YRESOLUTION, 1574.8031F);
  TIFFSetField(tiff, TIFFTAG_RESOLUTIONUNIT, RESUNIT_CENTIMETER);
  if (kind.floating) TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_IEEEFP);
  if (samples == 4) {
    const std::uint16_t alpha = EXTRASAMPLE_UNASSALPHA;
    TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, 1, &alpha);
  }
  if (kind.tiled) {
    TIFFSetField(tiff, TIFFTAG_TILEWIDTH, 16);
    TIFFSetField(tiff, TIFFTAG_TILELENGTH, 16);
  } else {
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 5);
  }
}

// One page with channels [first_channel, first_channel + samples).
void write_page(TIFF* tiff, const Kind& kind, int samples, int first_channel = 0) {
  set_tags(tiff, kind, samples);
  const int planes = kind.planar ? samples : 1;
  const int per_plane = samples / planes;
  const int block_width = kind.tiled ? 16 : kWidth, block_height = kind.tiled ? 16 : 1;
  std::vector<std::uint8_t> block(
      static_cast<std::size_t>(block_width * block_height * per_plane * kind.bits / 8));
  for (int plane = 0; plane < planes; ++plane) {
    for (int y0 = 0; y0 < kHeight; y0 += block_height) {
      for (int x0 = 0; x0 < kWidth; x0 += block_width) {
        for (int y = 0; y < block_height; ++y) {
          for (int x = 0; x < block_width; ++x) {
            for (int c = 0; c < per_plane; ++c) {
              const auto v = sample_at(y0 + y, first_channel + plane + c, x0 + x);
              put(kind, block, static_cast<std::size_t>((y * block_width + x) * per_plane + c), v);
            }
          }
        }
        if (kind.tiled) {
          TIFFWriteTile(tiff, block.data(), static_cast<std::uint32_t>(x0),
                        static_cast<std::uint32_t>(y0), 0, static_cast<std::uint16_t>(plane));
        } else {
          TIFFWriteScanline(tiff, block.data(), static_cast<std::uint32_t>(y0),
                            static_cast<std::uint16_t>(plane));
        }
      }
    }
  }
}

void write_tiff(const std::filesystem::path& path, const Kind& kind, int second_page_samples = 0) {
  TIFF* tiff = TIFFOpen(path.c_str(), kind.mode);
  ASSERT_NE(tiff, nullptr);
  write_page(tiff, kind, kind.samples);
  if (second_page_samples > 0) {
    TIFFWriteDirectory(tiff);
    write_page(tiff, kind, second_page_samples, 3);
  }
  TIFFClose(tiff);
}

void expect_pixels(const Scan& scan, const Kind& kind, int samples) {
  const auto& format = scan.source->format();
  ASSERT_EQ(format.width_px, kWidth);
  ASSERT_EQ(format.n_lines, kHeight);
  ASSERT_EQ(format.n_channels(), samples);
  ASSERT_EQ(scan.source->wait_committed(kHeight, {}), kHeight);
  std::vector<std::uint16_t> all(format.samples_per_line() * kHeight);
  scan.source->read(0, kHeight, all);
  std::size_t i = 0;
  int n_wrong = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int c = 0; c < samples; ++c) {
      for (int x = 0; x < kWidth; ++x) n_wrong += all[i++] != expected_sample(kind, y, c, x);
    }
  }
  EXPECT_EQ(n_wrong, 0);
}

std::string input_error(const std::filesystem::path& path, const ReadScanOptions& options = {}) {
  try {
    (void)read_scan(path, options);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

class ReadsKind : public testing::TestWithParam<Kind> {};

TEST_P(ReadsKind, EverySampleExactly) {
  const TempDir dir;
  const Kind& kind = GetParam();
  const auto path = dir / "scan.tif";
  write_tiff(path, kind);
  const Scan scan = read_scan(path);
  expect_pixels(scan, kind, kind.samples);
  EXPECT_EQ(scan.infrared, kind.samples == 4 ? InfraredFrom::kFourthSample : InfraredFrom::kNone);
  EXPECT_EQ(scan.source->format().plane_of(Channel::kInfrared), kind.samples == 4 ? 3 : -1);
  EXPECT_EQ(scan.file_bits, kind.bits);
  EXPECT_NEAR(scan.source->format().x_dpi, 4000, 0.01);
}

std::vector<Kind> kinds() {
  std::vector<Kind> all;
  for (const int bits : {8, 16, 32}) {
    for (const int samples : {3, 4}) {
      for (const bool planar : {false, true}) {
        for (const bool tiled : {false, true}) {
          for (const int compression :
               {COMPRESSION_NONE, COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE, COMPRESSION_PACKBITS,
                COMPRESSION_ZSTD}) {
            Kind kind{"", bits, samples, planar, tiled, compression, bits == 32};
            std::string& name = kind.name;
            name.append("bits").append(std::to_string(bits));
            name.append("_samples").append(std::to_string(samples));
            name.append(planar ? "_planar" : "_chunky").append(tiled ? "_tiles" : "_strips");
            name.append("_compression").append(std::to_string(compression));
            if (!TIFFIsCODECConfigured(static_cast<std::uint16_t>(compression))) continue;
            all.push_back(kind);
            if (compression != COMPRESSION_NONE || tiled) continue;
            kind.mode = "wb";  // big-endian
            kind.name += "_big_endian";
            all.push_back(kind);
            kind.mode = "w8";
            kind.name += "_bigtiff";
            all.push_back(kind);
          }
        }
      }
    }
  }
  return all;
}
std::string name_of_kind(const testing::TestParamInfo<Kind>& kind) { return kind.param.name; }
INSTANTIATE_TEST_SUITE_P(Layouts, ReadsKind, testing::ValuesIn(kinds()), name_of_kind);

TEST(ScanReader, InfraredOnASecondPage) {
  const TempDir dir;
  const Kind kind{.name = "", .samples = 3, .compression = COMPRESSION_LZW};
  write_tiff(dir / "hdri.tif", kind, 1);
  const Scan scan = read_scan(dir / "hdri.tif");
  EXPECT_EQ(scan.infrared, InfraredFrom::kSecondPage);
  expect_pixels(scan, kind, 4);
}

TEST(ScanReader, OtherPagesAreNotInfrared) {
  const TempDir dir;
  const Kind kind{.name = "", .samples = 3};
  write_tiff(dir / "two.tif", kind, 3);
  const Scan scan = read_scan(dir / "two.tif");
  EXPECT_EQ(scan.infrared, InfraredFrom::kNone);
  expect_pixels(scan, kind, 3);
  EXPECT_THAT(scan.notes, testing::Contains(testing::HasSubstr("further page")));
}

TEST(ScanReader, InfraredBesideTheScan) {
  const TempDir dir;
  const Kind rgb{.name = "", .samples = 3};
  Kind grey{.name = "", .samples = 1};
  for (const std::string name : {"a_IR.tif", "b-ir.tif"}) {
    write_tiff(dir / (name.substr(0, 1) + ".tif"), rgb);
    TIFF* tiff = TIFFOpen((dir / name).c_str(), "w");
    write_page(tiff, grey, 1, 3);
    TIFFClose(tiff);
    const Scan scan = read_scan(dir / (name.substr(0, 1) + ".tif"));
    EXPECT_EQ(scan.infrared, InfraredFrom::kSidecar);
    EXPECT_EQ(scan.infrared_path, dir / name);
    expect_pixels(scan, rgb, 4);
  }
  ReadScanOptions options;
  options.look_for_sidecar = false;
  EXPECT_EQ(read_scan(dir / "a.tif", options).infrared, InfraredFrom::kNone);
  options.infrared_file = dir / "a_IR.tif";
  expect_pixels(read_scan(dir / "b.tif", options), rgb, 4);
  // It replaces a fourth sample.
  const Kind rgbi{.name = "", .samples = 4};
  write_tiff(dir / "c.tif", rgbi);
  const Scan replaced = read_scan(dir / "c.tif", options);
  EXPECT_EQ(replaced.infrared, InfraredFrom::kSidecar);
  expect_pixels(replaced, rgbi, 4);
  options.infrared_file = dir / "b.tif";
  EXPECT_THAT(input_error(dir / "a.tif", options), testing::HasSubstr("3 channels instead of one"));
}

TEST(ScanReader, OwnMasterIsReadOnDemandWithItsContext) {
  const TempDir dir;
  const auto format = test::small_format(300, 40);
  MasterOptions options;
  options.path = dir / "m.tif";
  options.film = "dufay";
  MasterWriter writer(options);
  writer.begin(format, test::small_context());
  writer.lines(test::block_of(format, 0, 40));
  writer.end(ScanEnd::kComplete);
  const Scan scan = read_scan(dir / "m.tif");
  EXPECT_NE(dynamic_cast<const MasterFileSource*>(scan.source.get()), nullptr);
  EXPECT_EQ(scan.source->format().channels, format.channels);
  EXPECT_EQ(scan.source->format().x_dpi, 4000);
  std::vector<std::uint16_t> lines(format.samples_per_line() * 40);
  scan.source->read(0, 40, lines);
  EXPECT_EQ(lines, test::block_of(format, 0, 40).samples);
  EXPECT_EQ(scan.context.serial, test::small_context().serial);
  EXPECT_EQ(scan.context.exposure_us, test::small_context().exposure_us);
  EXPECT_EQ(scan.film, "dufay");
  EXPECT_EQ(scan.date_time, "2026:11:22 10:15:00");
  EXPECT_EQ(scan.tone.table(0), ToneCurves::linear().table(0));
  EXPECT_THAT(scan.notes, testing::ElementsAre(testing::HasSubstr("linear")));
}

TEST(ScanReader, HonoursProfileAndGamma) {
  const TempDir dir;
  const auto path = dir / "srgb.tif";
  TIFF* tiff = TIFFOpen(path.c_str(), "w");
  const auto icc = srgb_icc();
  TIFFSetField(tiff, TIFFTAG_ICCPROFILE, static_cast<std::uint32_t>(icc.size()), icc.data());
  write_page(tiff, Kind{.name = ""}, 4);
  TIFFClose(tiff);
  const Scan scan = read_scan(path);
  for (const int v : {0, 1000, 2650, 20000, 65535}) {
    const double x = v / 65535.0;
    const double linear = x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
    EXPECT_NEAR(scan.tone.table(1)[static_cast<std::size_t>(v)], linear, 2e-5);
    EXPECT_FLOAT_EQ(scan.tone.table(3)[static_cast<std::size_t>(v)], static_cast<float>(x));
  }
  ReadScanOptions options;
  options.gamma = 2.2;
  const Scan gamma = read_scan(path, options);
  for (const int channel : {0, 3}) {
    EXPECT_NEAR(gamma.tone.table(channel)[32768], std::pow(32768 / 65535.0, 2.2), 1e-6);
  }
}

TEST(ScanReader, SaysWhatIsWrong) {
  const TempDir dir;
  using testing::HasSubstr;
  write_bytes(dir / "empty.tif", "");
  EXPECT_THAT(input_error(dir / "empty.tif"), HasSubstr("is empty"));
  EXPECT_THAT(input_error(dir.path()), HasSubstr("is a folder"));
  EXPECT_THAT(input_error(dir / "none.tif"), HasSubstr("There is no file"));
  write_bytes(dir / "text.tif", "hello, this is text");
  EXPECT_THAT(input_error(dir / "text.tif"), HasSubstr("not a TIFF"));
  write_bytes(dir / "short.tif", "II");
  EXPECT_THAT(input_error(dir / "short.tif"), HasSubstr("not a TIFF"));
  write_bytes(dir / "jpeg.tif", "\xFF\xD8\xFF\xE0 and so on, a JPEG");
  EXPECT_THAT(input_error(dir / "jpeg.tif"), HasSubstr("JPEG"));
  ASSERT_EQ(::mkfifo((dir / "fifo.tif").c_str(), 0600), 0);
  EXPECT_THAT(input_error(dir / "fifo.tif"), HasSubstr("not a regular file"));
  write_tiff(dir / "grey.tif", Kind{.name = "", .samples = 1});
  EXPECT_THAT(input_error(dir / "grey.tif"), HasSubstr("only one channel"));
  write_tiff(dir / "five.tif", Kind{.name = "", .samples = 5});
  EXPECT_THAT(input_error(dir / "five.tif"), HasSubstr("5 channels"));
  ReadScanOptions tiny;
  tiny.max_memory_bytes = 100;
  write_tiff(dir / "lzw.tif", Kind{.name = "", .compression = COMPRESSION_LZW});
  EXPECT_THAT(input_error(dir / "lzw.tif", tiny), HasSubstr("memory"));
}

TEST(ScanReader, GreyOnlyWhenAskedFor) {
  const TempDir dir;
  const Kind grey{.name = "", .samples = 1};
  write_tiff(dir / "grey.tif", grey);
  ReadScanOptions options;
  options.allow_grey = true;
  const Scan scan = read_scan(dir / "grey.tif", options);
  EXPECT_EQ(scan.source->format().channels, std::vector<Channel>{Channel::kGrey});
  expect_pixels(scan, grey, 1);
}

TEST(ScanReader, RefusesWhatTheSystemRefuses) {
  const TempDir dir;
  write_tiff(dir / "secret.tif", Kind{.name = ""});
  ASSERT_EQ(::chmod((dir / "secret.tif").c_str(), 0), 0);
  // Root may read everything, so be somebody else for a moment.
  const bool root = ::geteuid() == 0;
  if (root) {
    ASSERT_EQ(::chmod(dir.path().c_str(), 0755), 0);
    ASSERT_EQ(::seteuid(65534), 0);
  }
  EXPECT_THROW((void)read_scan(dir / "secret.tif"), std::system_error);
  if (root) {
    ASSERT_EQ(::seteuid(0), 0);
  }
}

TEST(ScanReader, TruncatedFilesAreCountedOrUsedToTheLastLine) {
  const TempDir dir;
  // A master has its directory in front, so that it can be cut anywhere.
  const auto format = test::small_format(300, 40);
  MasterOptions options;
  options.path = dir / "m.tif";
  MasterWriter writer(options);
  writer.begin(format, test::small_context());
  writer.lines(test::block_of(format, 0, 40));
  writer.end(ScanEnd::kComplete);
  const auto whole = file_bytes(dir / "m.tif");
  const std::size_t row = format.samples_per_line() * 2;
  write_bytes(dir / "cut.tif", whole.substr(0, whole.size() - 10 * row - 3));
  EXPECT_THAT(input_error(dir / "cut.tif"), testing::HasSubstr("29 of 40 lines can be read"));
  ReadScanOptions accept;
  accept.accept_truncated = true;
  const Scan scan = read_scan(dir / "cut.tif", accept);
  EXPECT_TRUE(scan.truncated);
  ASSERT_EQ(scan.source->format().n_lines, 29);
  std::vector<std::uint16_t> lines(format.samples_per_line() * 29);
  scan.source->read(0, 29, lines);
  EXPECT_EQ(lines, test::block_of(format, 0, 29).samples);
  write_bytes(dir / "head.tif", whole.substr(0, 600));
  EXPECT_NE(input_error(dir / "head.tif", accept), "no error");

  // libtiff puts the directory behind the pixels.
  write_tiff(dir / "lzw.tif", Kind{.name = "", .compression = COMPRESSION_LZW});
  const auto lzw = file_bytes(dir / "lzw.tif");
  write_bytes(dir / "lzw_cut.tif", lzw.substr(0, lzw.size() / 2));
  EXPECT_THAT(input_error(dir / "lzw_cut.tif"), testing::HasSubstr("is cut off after"));
}

TEST(ScanReader, AbsurdDimensionsAllocateNothing) {
  const TempDir dir;
  for (const int compression : {COMPRESSION_NONE, COMPRESSION_LZW}) {
    write_tiff(dir / "x.tif", Kind{.name = "", .compression = compression});
    TIFF* tiff = TIFFOpen((dir / "x.tif").c_str(), "r+");
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, 900000);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, 900000);
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 900000);
    TIFFRewriteDirectory(tiff);
    TIFFClose(tiff);
    EXPECT_NE(input_error(dir / "x.tif"), "no error");
    ReadScanOptions accept;
    accept.accept_truncated = true;
    EXPECT_NE(input_error(dir / "x.tif", accept), "no error");
  }
}

TEST(ScanReader, RealCropHasItsKnownMeans) {
  const std::filesystem::path path =
      std::filesystem::path(RESEAU_SHARED_DIR) / "data/scans/dufaycolor-ls9000-4000dpi-party.tif";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no " << path;
  const Scan scan = read_scan(path);
  const auto& format = scan.source->format();
  ASSERT_EQ(format.n_channels(), 4);
  std::vector<std::uint16_t> all(format.samples_per_line() *
                                 static_cast<std::size_t>(format.n_lines));
  scan.source->read(0, format.n_lines, all);
  std::array<double, 4> sums{};
  for (std::size_t i = 0; i < all.size(); ++i) {
    sums[i / static_cast<std::size_t>(format.width_px) % 4] += all[i] / 257.0;
  }
  // Independently measured with another decoder.
  const std::array<double, 4> known = {18.56, 13.02, 12.94, 31.73};
  for (std::size_t c = 0; c < 4; ++c) {
    EXPECT_NEAR(sums[c] / format.width_px / format.n_lines, known[c], 0.005);
  }
  EXPECT_EQ(scan.infrared, InfraredFrom::kFourthSample);
}

}  // namespace
}  // namespace reseau
