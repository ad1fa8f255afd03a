#include "capture/store/master_layout.h"

#include <cstring>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <tiffio.h>
#include <unistd.h>

#include "core/base/error.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/capture/scan_fixture.h"

namespace reseau {
namespace {

using test::small_context;
using test::small_format;
using test::TempDir;

MasterLayout layout_of(const LineFormat& format, std::uint64_t limit = kClassicTiffLimit) {
  return plan_master(format, make_master_tags(format, small_context(), "dufay"), limit);
}

TEST(MasterLayout, BecomesBigTiffExactlyAboveTheLimit) {
  const auto format = small_format(1000, 100);
  const auto total = layout_of(format).total_bytes;
  EXPECT_FALSE(layout_of(format, total).big);
  EXPECT_TRUE(layout_of(format, total - 1).big);
  // The largest scan that still has 32-bit offsets, and one line more.
  auto tall = small_format(8000, 60'000);
  while (layout_of(tall).big == false) ++tall.n_lines;
  EXPECT_GT(layout_of(tall).total_bytes, kClassicTiffLimit);
  --tall.n_lines;
  const auto classic = layout_of(tall);
  EXPECT_FALSE(classic.big);
  EXPECT_LE(classic.total_bytes, kClassicTiffLimit);
  EXPECT_GT(classic.total_bytes + classic.bytes_per_row, kClassicTiffLimit);
}

TEST(MasterLayout, NothingOverlaps) {
  for (const int n_lines : {1, 2, 7, 500}) {
    for (const bool big : {false, true}) {
      const auto layout = layout_of(small_format(9000, n_lines), big ? 0 : kClassicTiffLimit);
      const std::uint64_t entry = big ? 8 : 4;
      const auto strips = static_cast<std::uint64_t>(layout.strip_of(n_lines - 1) + 1);
      EXPECT_EQ(layout.big, big);
      EXPECT_GE(layout.offsets_table, kMasterHeadBytes);
      EXPECT_GE(layout.counts_table, layout.offsets_table + strips * entry);
      EXPECT_GE(layout.data_offset, layout.counts_table + strips * entry);
      EXPECT_EQ(layout.total_bytes,
                layout.data_offset + static_cast<std::uint64_t>(n_lines) * layout.bytes_per_row);
      EXPECT_EQ(encode_master_head(layout, n_lines).size(), kMasterHeadBytes);
      EXPECT_EQ(encode_master_values(layout, n_lines).size(),
                layout.data_offset - kMasterHeadBytes);
    }
  }
}

TEST(MasterLayout, StripCountsGrowIntoTheFinalTable) {
  const auto layout = layout_of(small_format(9000, 100));
  auto values = encode_master_values(layout, 0);
  for (int y = 0; y < 100; y += 9) {
    const auto patch = encode_strip_counts(layout, y, std::min(100, y + 9));
    std::copy(patch.bytes.begin(), patch.bytes.end(),
              values.begin() + static_cast<std::ptrdiff_t>(patch.offset - kMasterHeadBytes));
  }
  EXPECT_EQ(values, encode_master_values(layout, 100));
}

TEST(MasterLayout, RefusesNothingness) {
  EXPECT_THROW((void)layout_of(small_format(0, 5)), InputError);
  EXPECT_THROW((void)layout_of(small_format(5, 0)), InputError);
}

// A file of more than 4 GiB, of which only the head and two lines are written.
TEST(MasterLayout, LibtiffReadsTheLastLineBeyond4GiB) {
  const TempDir dir;
  const auto format = small_format(20'000, 30'000);
  const auto layout = layout_of(format);
  ASSERT_TRUE(layout.big);
  ASSERT_GT(layout.total_bytes, std::uint64_t{1} << 32);
  const auto path = dir / "big.tif";
  const int fd = ::open(path.c_str(), O_RDWR | O_CREAT, 0600);
  ASSERT_GE(fd, 0);
  if (::ftruncate(fd, static_cast<off_t>(layout.total_bytes)) != 0) {
    ::close(fd);
    GTEST_SKIP() << "no files above 4 GiB here";
  }
  const auto put = [&](std::uint64_t offset, const void* data, std::size_t size) {
    return ::pwrite(fd, data, size, static_cast<off_t>(offset)) == static_cast<ssize_t>(size);
  };
  const auto values = encode_master_values(layout, format.n_lines);
  const auto head = encode_master_head(layout, format.n_lines);
  ASSERT_TRUE(put(kMasterHeadBytes, values.data(), values.size()));
  ASSERT_TRUE(put(0, head.data(), head.size()));
  std::vector<std::uint16_t> line(format.samples_per_line());
  for (std::size_t i = 0; i < line.size(); ++i) line[i] = static_cast<std::uint16_t>(i * 7 + 1);
  ASSERT_TRUE(put(layout.row_offset(29'999), line.data(), line.size() * 2));
  ::close(fd);

  TIFF* tiff = TIFFOpen(path.c_str(), "r");
  ASSERT_NE(tiff, nullptr);
  EXPECT_NE(TIFFIsBigTIFF(tiff), 0);
  std::vector<std::uint16_t> back(line.size());
  EXPECT_EQ(TIFFReadScanline(tiff, back.data(), 29'999, 0), 1);
  EXPECT_EQ(back, line);
  EXPECT_EQ(TIFFReadScanline(tiff, back.data(), 15'000, 0), 1);
  EXPECT_EQ(back, std::vector<std::uint16_t>(line.size()));
  TIFFClose(tiff);
}

// What the tags say, as another program sees it.
TEST(MasterLayout, TagsAreThoseOfAMaster) {
  const TempDir dir;
  const auto format = small_format(9, 2);
  const auto layout = layout_of(format);
  auto bytes = encode_master_head(layout, 2);
  const auto values = encode_master_values(layout, 2);
  bytes.insert(bytes.end(), values.begin(), values.end());
  bytes.resize(layout.total_bytes);
  test::write_bytes(dir / "m.tif", {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  TIFF* tiff = TIFFOpen((dir / "m.tif").c_str(), "r");
  ASSERT_NE(tiff, nullptr);
  const auto text = [&](std::uint32_t tag) {
    const char* value = nullptr;
    return std::string(TIFFGetField(tiff, tag, &value) == 1 ? value : "(none)");
  };
  EXPECT_EQ(text(TIFFTAG_MAKE), "Nikon");
  EXPECT_EQ(text(TIFFTAG_MODEL), "LS-5000 ED");
  EXPECT_EQ(text(TIFFTAG_DATETIME), "2026:11:22 10:15:00");
  EXPECT_EQ(text(TIFFTAG_SOFTWARE).rfind("reseau ", 0), 0U);
  EXPECT_NE(text(TIFFTAG_IMAGEDESCRIPTION).find("red, green, blue, infrared"), std::string::npos);
  std::uint16_t count = 0, photometric = 0, planar = 0, bits = 0, compression = 0;
  const std::uint16_t* extra = nullptr;
  EXPECT_EQ(TIFFGetField(tiff, TIFFTAG_EXTRASAMPLES, &count, &extra), 1);
  ASSERT_EQ(count, 1);
  EXPECT_EQ(extra[0], EXTRASAMPLE_UNSPECIFIED);
  TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &photometric);
  TIFFGetField(tiff, TIFFTAG_PLANARCONFIG, &planar);
  TIFFGetField(tiff, TIFFTAG_BITSPERSAMPLE, &bits);
  TIFFGetField(tiff, TIFFTAG_COMPRESSION, &compression);
  EXPECT_EQ(photometric, PHOTOMETRIC_RGB);
  EXPECT_EQ(planar, PLANARCONFIG_CONTIG);
  EXPECT_EQ(bits, 16);
  EXPECT_EQ(compression, COMPRESSION_NONE);
  float dpi = 0;
  TIFFGetField(tiff, TIFFTAG_XRESOLUTION, &dpi);
  EXPECT_EQ(dpi, 4000.0F);
  EXPECT_EQ(TIFFReadDirectory(tiff), 0);  // one directory
  TIFFClose(tiff);
}

}  // namespace
}  // namespace reseau
