// The simulated unit misbehaves; the program must not hang and must not lose a line.
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/image/scan_reader.h"
#include "tests/e2e/reseau_run.h"

namespace reseau::testing {
namespace {

using ::testing::HasSubstr;

std::vector<std::string> tiny_scan(const std::string& device, const std::string& output) {
  return {"scan", "-d", device, "-x", "0.6mm", "-y", "0.6mm", "-o", output, "--json"};
}

// Lines of the last progress event of the scan.
int announced_lines(const std::vector<nlohmann::json>& lines) {
  int rows = 0;
  for (const auto& event : events_of(lines, "progress")) {
    if (event["phase"] == "scan") rows = event["rows_done"];
  }
  return rows;
}

void check_broken_off(const ProcessResult& result, const TempDir& dir, const std::string& what) {
  const auto lines = json_lines(result.out);
  ASSERT_FALSE(lines.empty());
  EXPECT_EQ(lines.back()["exit"], result.exit_code) << what;
  const std::filesystem::path partial = dir / "a.partial.tif";
  const bool kept = std::filesystem::exists(partial);
  const auto errors = events_of(lines, "error");
  ASSERT_FALSE(errors.empty()) << what << result.err;
  EXPECT_FALSE(errors[0]["message"].get<std::string>().empty());
  if (result.exit_code == 75) {
    ASSERT_TRUE(kept) << what;
    EXPECT_GE(read_scan(partial).source->format().n_lines, announced_lines(lines)) << what;
    EXPECT_THAT(errors[0]["message"], HasSubstr("a.partial.tif")) << what;
  } else {
    EXPECT_EQ(result.exit_code, 9) << what << result.err;
    EXPECT_FALSE(kept) << what;
    EXPECT_EQ(announced_lines(lines), 0) << what;
  }
}

void sweep(const std::string& fault) {
  int n_partial = 0;
  int n_before = 0;
  // Dense at the start, where commands are short, then in growing steps until the scan survives.
  for (int n = 1; n < 4000; n += 1 + n / 12) {
    const TempDir dir;
    const std::string device = "sim:ls5000?" + fault + "=" + std::to_string(n);
    const ProcessResult result = reseau(tiny_scan(device, dir / "a.tif"));
    if (result.timed_out) FAIL() << device;
    if (result.exit_code == 0) {
      EXPECT_TRUE(std::filesystem::exists(dir / "a.tif"));
      if (fault == "unplug_after") break;
      continue;
    }
    check_broken_off(result, dir, device + "\n");
    if (result.exit_code == 75) ++n_partial;
    if (result.exit_code == 9) ++n_before;
    if (::testing::Test::HasFailure()) return;
  }
  EXPECT_GT(n_before, 0) << "the sweep never met the time before the first line";
  if (fault == "unplug_after") {
    EXPECT_GT(n_partial, 0) << "the sweep never met the lines";
  }
}

TEST(FaultsE2e, UnplugAtAnyTransfer) { sweep("unplug_after"); }

TEST(FaultsE2e, ASingleStallAtAnyTransferEndsCleanly) {
  for (int n = 1; n < 400; n += 1 + n / 4) {
    const TempDir dir;
    const std::string device = "sim:ls5000?stall_after=" + std::to_string(n);
    const ProcessResult result = reseau(tiny_scan(device, dir / "a.tif"));
    if (result.timed_out) FAIL() << device;
    if (result.exit_code != 0) check_broken_off(result, dir, device + "\n");
    if (::testing::Test::HasFailure()) return;
  }
}

TEST(FaultsE2e, ASilentUnitIsGivenUp) {
  for (const int n : {1, 20, 60, 120}) {
    const TempDir dir;
    const std::string device = "sim:ls5000?silent_after=" + std::to_string(n);
    const ProcessResult result = reseau(tiny_scan(device, dir / "a.tif"));
    if (result.timed_out) FAIL() << device;
    if (result.exit_code != 0) check_broken_off(result, dir, device + "\n");
  }
}

TEST(FaultsE2e, HabitsOfRealUnitsAreNoFaults) {
  for (const char* habit : {"cold=1", "busy_polls=40", "stale=512"}) {
    const TempDir dir;
    const ProcessResult result =
        reseau(tiny_scan(std::string("sim:ls5000?") + habit, dir / "a.tif"));
    EXPECT_EQ(result.exit_code, 0) << habit << "\n" << result.err;
  }
}

}  // namespace
}  // namespace reseau::testing
