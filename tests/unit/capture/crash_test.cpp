// What is left of a scan when the program is killed or the disk is full.
#include <csignal>
#include <system_error>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "capture/image/picture_writer.h"
#include "capture/image/scan_reader.h"
#include "capture/store/master_writer.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/capture/scan_fixture.h"

namespace reseau {
namespace {

using test::block_of;
using test::check_tiff;
using test::names_in;
using test::small_context;
using test::small_format;
using test::TempDir;

constexpr int kWidth = 9000, kLines = 400;

// Writes lines for ever slower than it is killed; tells after each block how many are committed.
[[noreturn]] void scan_in_child(const std::filesystem::path& path, int tell_fd, bool big) {
  const auto format = small_format(kWidth, kLines);
  MasterOptions options;
  options.path = path;
  if (big) options.bigtiff_above_bytes = 1000;
  MasterWriter writer(options);
  writer.begin(format, small_context());
  for (int y = 0; y < kLines; y += 3) {
    const int n = std::min(3, kLines - y);
    writer.lines(block_of(format, y, n));
    const int committed = y + n;
    if (::write(tell_fd, &committed, sizeof committed) != sizeof committed) ::_exit(1);
  }
  ::pause();
  ::_exit(1);
}

class KilledScan : public testing::TestWithParam<int> {};

TEST_P(KilledScan, LeavesEveryCommittedLine) {
  const int kill_after = GetParam();
  for (const bool big : {false, true}) {
    const TempDir dir;
    int pipe_fds[2];
    ASSERT_EQ(::pipe(pipe_fds), 0);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      ::close(pipe_fds[0]);
      scan_in_child(dir / "scan.tif", pipe_fds[1], big);
    }
    ::close(pipe_fds[1]);
    int committed = 0;
    while (committed < kill_after &&
           ::read(pipe_fds[0], &committed, sizeof committed) == sizeof committed) {
    }
    // Somewhere inside the next block.
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    while (::read(pipe_fds[0], &committed, sizeof committed) == sizeof committed) {
    }
    ::close(pipe_fds[0]);

    ASSERT_GE(committed, kill_after);
    const auto part = dir / ".scan.tif.part";
    const auto check = check_tiff(part, small_format(kWidth, kLines));
    EXPECT_GE(check.claimed, committed);
    EXPECT_LE(check.claimed, committed + 3);
    EXPECT_EQ(check.right, check.claimed);
    EXPECT_TRUE(check.complaints.empty()) << check.complaints.front();
    EXPECT_EQ(read_scan(part).source->format().n_lines, check.claimed);
  }
}

INSTANTIATE_TEST_SUITE_P(After, KilledScan, testing::Values(3, 6, 9, 30, 57, 120, 201, 300, 400));

// Limits the size of files this process may write, as a full disk would.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : old_handler_(::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &old_);
    rlimit limit = old_;
    limit.rlim_cur = bytes;
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &old_);
    ::signal(SIGXFSZ, old_handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit old_{};
  void (*old_handler_)(int);
};

TEST(FullDisk, KeepsEveryLineThatFitted) {
  const TempDir dir;
  const auto format = small_format(kWidth, kLines);
  const auto layout =
      plan_master(format, make_master_tags(format, small_context(), ""), kClassicTiffLimit);
  for (const int fitting : {1, 7, 50}) {
    const auto path = dir / ("scan" + std::to_string(fitting) + ".tif");
    MasterOptions options;
    options.path = path;
    MasterWriter writer(options);
    writer.begin(format, small_context());
    int failed_at = -1;
    {
      // Half of a line more than fits.
      const FileSizeLimit limit(layout.row_offset(fitting) + layout.bytes_per_row / 2);
      for (int y = 0; y < kLines && failed_at < 0; y += 4) {
        try {
          writer.lines(block_of(format, y, 4));
        } catch (const std::system_error& error) {
          failed_at = y;
          EXPECT_EQ(error.code().value(), EFBIG);
          EXPECT_NE(std::string(error.what()).find(path.string()), std::string::npos);
        }
      }
      EXPECT_EQ(failed_at, fitting / 4 * 4);
      EXPECT_EQ(check_tiff(part_path_of(path), format).right, fitting);
      EXPECT_EQ(writer.source()->committed(), fitting);
      writer.end(ScanEnd::kFailed);
    }
    EXPECT_EQ(writer.result().error, nullptr);
    EXPECT_EQ(writer.result().n_lines, fitting);
    EXPECT_EQ(check_tiff(writer.result().path, format).right, fitting);
    EXPECT_EQ(std::filesystem::file_size(writer.result().path), layout.row_offset(fitting));
  }
}

TEST(FullDisk, RoomIsMissedBeforeTheScan) {
  // A tebibyte and a half of a scan; where a disk has room for that, nothing is to be tested.
  const TempDir dir;
  if (std::filesystem::space(dir.path()).available > (std::uint64_t{3} << 39)) GTEST_SKIP();
  MasterOptions options;
  options.path = dir / "huge.tif";
  MasterWriter writer(options);
  try {
    writer.begin(small_format(200'000, 1'000'000), small_context());
    GTEST_SKIP() << "this file system cannot reserve room";
  } catch (const std::system_error& error) {
    if (error.code().value() == EFBIG) GTEST_SKIP() << "files cannot be that large here";
    EXPECT_NE(std::string(error.what()).find("needs 1600"), std::string::npos) << error.what();
  }
  EXPECT_TRUE(names_in(dir.path()).empty());
}

TEST(FullDisk, PicturesLeaveNothingBehind) {
  const TempDir dir;
  {
    const FileSizeLimit limit(20'000);
    for (const char* view : {"", "x.tif", "x.png"}) {
      PictureOptions options;
      options.exr = dir / "x.exr";
      if (view == std::string("x.tif")) options.tiff = dir / view;
      if (view == std::string("x.png")) options.png = dir / view;
      const auto write = [&] {
        PictureWriter writer(options);
        writer.begin(100, 100);
        std::vector<float> rows(100 * 100 * 3, 0.25F);
        writer.rows(0, 100, rows);
        writer.end();
      };
      EXPECT_THROW(write(), std::system_error);
    }
  }
  EXPECT_TRUE(names_in(dir.path()).empty());
}

}  // namespace
}  // namespace reseau
