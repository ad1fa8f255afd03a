// The host side of a recorded Nikon Scan session on a real LS-5000 against the simulated one:
// phases, statuses and small data must be the same wherever the state is.
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/unit/sim/sim_host.h"

namespace reseau::sim {
namespace {

// READ 8E: the film of the recording has other perforation counts than the simulated one.
bool depends_on_the_film(const std::string& cdb) {
  return cdb.starts_with("28008e") && cdb != "28008e00000000000680";
}

TEST(SessionReplay, RecordedNikonScanSessionMeetsTheSameAnswers) {
  const std::filesystem::path path =
      std::filesystem::path(RESEAU_SHARED_DIR) / "data/sessions/ls5000-nikonscan4-rgbi4.jsonl";
  std::ifstream file(path);
  if (!file) GTEST_SKIP() << "no recorded session at " << path;
  SimHost host("sim:ls5000?frames=37&film_arrives=10&cells=1");
  const std::string poll = "000000000000";
  std::string last_poll;
  int compared = 0;
  for (std::string line; std::getline(file, line);) {
    const nlohmann::json entry = nlohmann::json::parse(line);
    const std::string cdb = entry["cdb"], expected = entry["expected_status"];
    SCOPED_TRACE("entry " + entry["seq"].dump() + ", " + cdb);
    if (cdb == poll) {
      // How often the unit is polled depends on its speed; which answers follow each other does
      // not.
      if (expected == last_poll && expected != SimHost::kGoodStatus) continue;
      std::string status = host.test_unit_ready();
      for (int n = 0; status == last_poll && status != expected && n < 1000; ++n) {
        status = host.test_unit_ready();
      }
      ASSERT_EQ(status, expected);
      last_poll = status;
      ++compared;
      continue;
    }
    last_poll.clear();
    if (depends_on_the_film(cdb)) continue;
    const std::size_t asked = entry.value("request_len", 0U);
    const std::string data_out = entry.value("data_out", "");
    const Exchange e = host.run(cdb, asked, from_hex(data_out), true);
    EXPECT_EQ(e.phase, entry["expected_phase"].get<int>());
    ASSERT_EQ(e.status, expected);
    ASSERT_EQ(e.data.size(), asked);
    const std::string data = entry.value("expected_data_in", "");
    const bool image = cdb.starts_with("280000");
    const bool perforation_count = cdb == "28008e00000000000680";
    if (!data.empty() && !image && !perforation_count) {
      EXPECT_EQ(to_hex(e.data), data);
    }
    ++compared;
  }
  EXPECT_GT(compared, 150);
}

}  // namespace
}  // namespace reseau::sim
