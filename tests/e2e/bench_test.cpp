// What `reseau bench` prints, on its smallest cases. Times are only looked at for being there.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/e2e/reseau_run.h"

namespace reseau::testing {
namespace {

TEST(BenchE2e, SpeedTellsTimeMemoryAndBandwidth) {
  const TempDir dir;
  const ProcessResult result =
      reseau({"bench", "speed", "--megapixels", "1", "--quality", "draft", "--threads", "1,2",
              "--repeat", "1", "--plot", dir / "speed.svg", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto report = nlohmann::json::parse(result.out);
  EXPECT_EQ(report["schema"], "reseau-bench-speed/1");
  EXPECT_EQ(report["bandwidth_bytes_per_s"].size(), 2U);
  ASSERT_EQ(report["cases"].size(), 2U);
  for (const auto& row : report["cases"]) {
    EXPECT_EQ(row["found"], true) << row.dump();
    EXPECT_GT(row["cpu_s"]["register"], 0);
    EXPECT_GT(row["cpu_s"]["reconstruct"], 0);
    EXPECT_GT(row["share_of_bandwidth"], 0);
  }
  EXPECT_THAT(file_bytes(dir / "speed.svg"), ::testing::HasSubstr("draft, 1 thread"));
}

TEST(BenchE2e, StressTellsWhatWasAnsweredAndWhatRefused) {
  const ProcessResult result =
      reseau({"bench", "stress", "--random", "0", "--only", "white level", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto cases = events_of(json_lines(result.out), "case");
  ASSERT_EQ(cases.size(), 3U);
  for (const auto& row : cases) {
    EXPECT_EQ(row["outcome"], "refused") << row.dump();
    EXPECT_NE(row["words"], "") << row.dump();
  }
}

}  // namespace
}  // namespace reseau::testing
