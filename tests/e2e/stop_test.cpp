// A person or the system ends the program while the film moves.
#include <csignal>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/image/scan_reader.h"
#include "tests/e2e/reseau_run.h"

namespace reseau::testing {
namespace {

using std::chrono::seconds;
using ::testing::HasSubstr;

// A scan long enough to be interrupted: the whole frame.
std::vector<std::string> long_scan(const TempDir& dir) {
  return command({"scan", "-d", kDevice, "-o", dir / "a.tif", "--json"});
}

// Waits until lines are safe on disk; returns how many.
int wait_for_lines(Process& process) {
  int rows = 0;
  const bool seen = process.wait_for_line(
      [&rows](const std::string& line) {
        const auto event = nlohmann::json::parse(line, nullptr, false);
        if (!event.is_object() || event.value("event", "") != "progress") return false;
        if (event.value("phase", "") != "scan") return false;
        rows = event.value("rows_done", 0);
        return rows > 0;
      },
      seconds(120));
  EXPECT_TRUE(seen);
  return rows;
}

void interrupted_scan_keeps_its_lines(int signal) {
  const TempDir dir;
  Process process(long_scan(dir));
  const int announced = wait_for_lines(process);
  process.send(signal);
  const ProcessResult result = process.wait(seconds(120));
  ASSERT_FALSE(result.timed_out) << result.err;
  EXPECT_EQ(result.exit_code, 2) << result.err;
  EXPECT_THAT(result.err, HasSubstr("lines are safe in"));
  const Scan scan = read_scan(dir / "a.partial.tif");
  EXPECT_GE(scan.source->format().n_lines, announced);
  EXPECT_FALSE(std::filesystem::exists(dir / "a.tif"));
  const auto receipt = nlohmann::json::parse(file_bytes(dir / "a.partial.json"));
  EXPECT_EQ(receipt["scan"]["end"], "cancelled");
  EXPECT_EQ(receipt["scan"]["lines"], scan.source->format().n_lines);
}

TEST(StopE2e, CtrlCKeepsTheLines) { interrupted_scan_keeps_its_lines(SIGINT); }
TEST(StopE2e, TerminateKeepsTheLines) { interrupted_scan_keeps_its_lines(SIGTERM); }

TEST(StopE2e, ASecondCtrlCIsFasterAndStillKeepsTheLines) {
  const TempDir dir;
  Process process(long_scan(dir));
  const int announced = wait_for_lines(process);
  process.send(SIGINT);
  process.send(SIGTERM);  // two of the same could merge into one
  const ProcessResult result = process.wait(seconds(120));
  ASSERT_FALSE(result.timed_out) << result.err;
  EXPECT_EQ(result.exit_code, 130) << result.err;
  EXPECT_GE(read_scan(dir / "a.partial.tif").source->format().n_lines, announced);
  EXPECT_FALSE(std::filesystem::exists(dir / "a.partial.exr"));
}

TEST(StopE2e, KilledTheLinesThatWereAnnouncedAreInTheFile) {
  const TempDir dir;
  Process process(long_scan(dir));
  const int announced = wait_for_lines(process);
  process.send(SIGKILL);
  const ProcessResult result = process.wait(seconds(60));
  EXPECT_EQ(result.signal, SIGKILL);
  const auto part = dir.path() / ".a.tif.part";
  ASSERT_TRUE(std::filesystem::exists(part));
  EXPECT_GE(read_scan(part).source->format().n_lines, announced);
}

TEST(StopE2e, AScanAfterAKilledOneTakesAnotherNameAndHarmsNothing) {
  const TempDir dir;
  {
    Process process(command({"scan", "-d", kDevice, "-o", dir.path(), "--json"}));
    EXPECT_GT(wait_for_lines(process), 0);
    process.send(SIGKILL);
    static_cast<void>(process.wait(seconds(60)));
  }
  const auto part = only_file(dir.path(), ".part");
  const std::string bytes = file_bytes(part);
  auto next = small_scan(kDevice, dir.path());
  next.push_back("--no-reconstruct");
  EXPECT_EQ(reseau(next).exit_code, 0);
  EXPECT_TRUE(file_bytes(part) == bytes);
  only_file(dir.path(), "_02.tif");
}

TEST(StopE2e, ReconstructStopsAndLeavesNothing) {
  const TempDir dir;
  ASSERT_EQ(
      reseau({"simulate", "width_px=1500", "height_px=3000", "-o", dir / "film.tif"}).exit_code, 0);
  Process process(
      command({"reconstruct", dir / "film.tif", "-o", dir / "out", "--json", "--threads", "1"}));
  ASSERT_TRUE(process.wait_for_line(
      [](const std::string& line) { return line.find("\"register\"") != std::string::npos; },
      seconds(60)));
  process.send(SIGINT);
  const ProcessResult result = process.wait(seconds(60));
  ASSERT_FALSE(result.timed_out);
  // A fast machine may have finished before the signal came.
  if (result.exit_code == 0) GTEST_SKIP() << "finished before it could be stopped";
  EXPECT_EQ(result.exit_code, 2) << result.err;
  EXPECT_TRUE(names_in(dir / "out").empty());
}

}  // namespace
}  // namespace reseau::testing
