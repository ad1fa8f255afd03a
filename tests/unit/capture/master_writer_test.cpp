#include "capture/store/master_writer.h"

#include <thread>

#include <gtest/gtest.h>

#include "capture/store/master_xmp.h"
#include "core/base/error.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/capture/scan_fixture.h"

namespace reseau {
namespace {

using test::block_of;
using test::check_tiff;
using test::file_bytes;
using test::names_in;
using test::small_context;
using test::small_format;
using test::TempDir;

MasterResult write_master(const std::filesystem::path& path, const LineFormat& format,
                          int lines_per_block, int n_lines, ScanEnd end,
                          MasterOptions options = {}) {
  options.path = path;
  options.film = "dufay";
  MasterWriter writer(options);
  writer.begin(format, small_context());
  for (int y = 0; y < n_lines; y += lines_per_block) {
    writer.lines(block_of(format, y, std::min(lines_per_block, n_lines - y)));
  }
  writer.end(end);
  return writer.result();
}

// 9000 * 8 bytes = 7 rows per strip, so that 100 lines make several strips and a short last one.
constexpr int kWidth = 9000;

TEST(MasterWriter, WritesEveryLineForLibtiff) {
  const TempDir dir;
  for (const bool infrared : {true, false}) {
    const auto format = small_format(kWidth, 100, infrared);
    const auto path = dir / (infrared ? "rgbi.tif" : "rgb.tif");
    const auto result = write_master(path, format, 6, 100, ScanEnd::kComplete);
    EXPECT_EQ(result.path, path);
    EXPECT_TRUE(result.complete);
    EXPECT_EQ(result.error, nullptr);
    const auto check = check_tiff(path, format);
    EXPECT_EQ(check.claimed, 100);
    EXPECT_EQ(check.right, 100);
    EXPECT_EQ(check.complaints, std::vector<std::string>{});
  }
  EXPECT_EQ(names_in(dir.path()), (std::vector<std::string>{"rgb.tif", "rgbi.tif"}));
}

TEST(MasterWriter, BytesDoNotDependOnHowLinesAreGrouped) {
  const TempDir dir;
  const auto format = small_format(kWidth, 37);
  write_master(dir / "a.tif", format, 1, 37, ScanEnd::kComplete);
  write_master(dir / "b.tif", format, 10, 37, ScanEnd::kComplete);
  write_master(dir / "c.tif", format, 37, 37, ScanEnd::kComplete);
  EXPECT_EQ(file_bytes(dir / "a.tif"), file_bytes(dir / "b.tif"));
  EXPECT_EQ(file_bytes(dir / "a.tif"), file_bytes(dir / "c.tif"));
}

TEST(MasterWriter, IsAValidTiffAfterEveryLine) {
  const TempDir dir;
  for (const bool big : {false, true}) {
    const auto format = small_format(kWidth, 25);
    MasterOptions options;
    options.path = dir / (big ? "big.tif" : "classic.tif");
    if (big) options.bigtiff_above_bytes = 1000;
    MasterWriter writer(options);
    writer.begin(format, small_context());
    const auto part = part_path_of(options.path);
    for (int y = 0; y < 25; ++y) {
      writer.lines(block_of(format, y, 1));
      const auto check = check_tiff(part, format);
      ASSERT_EQ(check.claimed, y + 1);
      ASSERT_EQ(check.right, y + 1);
      ASSERT_EQ(check.complaints, std::vector<std::string>{});
    }
    writer.end(ScanEnd::kComplete);
    EXPECT_EQ(check_tiff(options.path, format).right, 25);
  }
}

TEST(MasterWriter, CancelledScanIsKeptAsPartial) {
  const TempDir dir;
  const auto format = small_format(kWidth, 50);
  const auto result = write_master(dir / "x.tif", format, 4, 23, ScanEnd::kCancelled);
  EXPECT_EQ(result.path, dir / "x.partial.tif");
  EXPECT_FALSE(result.complete);
  EXPECT_EQ(result.n_lines, 23);
  EXPECT_EQ(check_tiff(result.path, format).right, 23);
  const auto second = write_master(dir / "x.tif", format, 4, 9, ScanEnd::kFailed);
  EXPECT_EQ(second.path, dir / "x.partial-2.tif");
  EXPECT_EQ(check_tiff(result.path, format).right, 23);
}

TEST(MasterWriter, ScanWithoutALineLeavesNothing) {
  const TempDir dir;
  const auto result = write_master(dir / "x.tif", small_format(9, 5), 1, 0, ScanEnd::kFailed);
  EXPECT_TRUE(result.path.empty());
  EXPECT_TRUE(names_in(dir.path()).empty());
}

TEST(MasterWriter, NeverOverwrites) {
  const TempDir dir;
  const auto format = small_format(9, 5);
  test::write_bytes(dir / "x.tif", "mine");
  EXPECT_THROW(write_master(dir / "x.tif", format, 1, 5, ScanEnd::kComplete), InputError);
  test::write_bytes(dir / ".y.tif.part", "lines of a killed scan");
  EXPECT_THROW(write_master(dir / "y.tif", format, 1, 5, ScanEnd::kComplete), InputError);
  EXPECT_EQ(file_bytes(dir / "x.tif"), "mine");
  EXPECT_EQ(file_bytes(dir / ".y.tif.part"), "lines of a killed scan");

  // Taken while the scan runs.
  MasterOptions options;
  options.path = dir / "z.tif";
  MasterWriter writer(options);
  writer.begin(format, small_context());
  writer.lines(block_of(format, 0, 5));
  test::write_bytes(dir / "z.tif", "another program");
  writer.end(ScanEnd::kComplete);
  EXPECT_EQ(writer.result().path, dir / "z-2.tif");
  EXPECT_EQ(file_bytes(dir / "z.tif"), "another program");
  EXPECT_EQ(check_tiff(dir / "z-2.tif", format).right, 5);
}

TEST(MasterWriter, UnwritableFolderIsAnErrorOfTheSystem) {
  EXPECT_THROW(write_master("/no-such-folder/x.tif", small_format(9, 5), 1, 5, ScanEnd::kComplete),
               std::system_error);
}

TEST(MasterFileSource, ReadsBelowTheWatermarkWhileTheFileGrows) {
  const TempDir dir;
  const auto format = small_format(kWidth, 60);
  MasterOptions options;
  options.path = dir / "live.tif";
  MasterWriter writer(options);
  writer.begin(format, small_context());
  const auto source = writer.source();
  EXPECT_EQ(source->committed(), 0);
  int n_right = 0;
  std::jthread reader([&] {
    for (int y = 0; y < 60; y += 5) {
      if (source->wait_committed(y + 5, {}) < y + 5) return;
      std::vector<std::uint16_t> lines(format.samples_per_line() * 5);
      source->read(y, 5, lines);
      if (lines == block_of(format, y, 5).samples) n_right += 5;
    }
  });
  for (int y = 0; y < 60; y += 3) writer.lines(block_of(format, y, 3));
  writer.end(ScanEnd::kComplete);
  reader.join();
  EXPECT_EQ(n_right, 60);
  // After the rename the same source reads on.
  std::vector<std::uint16_t> all(format.samples_per_line() * 60);
  source->read(0, 60, all);
  EXPECT_EQ(all, block_of(format, 0, 60).samples);
}

TEST(MasterFileSource, WaitingEndsWithTheScanAndWithAStopRequest) {
  const TempDir dir;
  const auto format = small_format(9, 20);
  MasterOptions options;
  options.path = dir / "short.tif";
  MasterWriter writer(options);
  writer.begin(format, small_context());
  writer.lines(block_of(format, 0, 7));
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(writer.source()->wait_committed(20, stop.get_token()), 7);
  writer.end(ScanEnd::kCancelled);
  EXPECT_EQ(writer.source()->wait_committed(20, {}), 7);
}

TEST(MasterXmp, ComesBackExactly) {
  const auto context = small_context();
  const auto xmp = make_master_xmp(small_format(9, 5), context, "dufay & <paget>");
  const auto back = read_master_xmp(xmp);
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(back->film, "dufay & <paget>");
  EXPECT_EQ(back->context.serial, context.serial);
  EXPECT_EQ(back->context.device_name, context.device_name);
  EXPECT_EQ(back->context.model, context.model);
  EXPECT_EQ(back->context.firmware, context.firmware);
  EXPECT_EQ(back->context.holder, context.holder);
  EXPECT_EQ(back->context.started_at_utc, context.started_at_utc);
  EXPECT_EQ(back->context.focus_position, context.focus_position);
  EXPECT_EQ(back->context.exposure_us, context.exposure_us);
  EXPECT_NE(xmp.find("<rdf:li>infrared</rdf:li>"), std::string::npos);
  EXPECT_FALSE(read_master_xmp("<x:xmpmeta/>").has_value());
}

}  // namespace
}  // namespace reseau
