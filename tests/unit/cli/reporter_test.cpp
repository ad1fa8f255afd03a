#include "capture/cli/reporter.h"

#include <limits>
#include <sstream>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace reseau::cli {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;
using ::testing::HasSubstr;
using ::testing::Not;

steady_clock::time_point g_now;
steady_clock::time_point fake_now() { return g_now; }

class ReporterTest : public ::testing::Test {
 protected:
  Reporter make(const ReportOptions& options, bool terminal) {
    return Reporter(options, "scan", out, talk, terminal, &fake_now);
  }
  std::vector<nlohmann::json> events() const {
    std::vector<nlohmann::json> list;
    std::istringstream lines(out.str());
    for (std::string line; std::getline(lines, line);) list.push_back(nlohmann::json::parse(line));
    return list;
  }
  // A scan of 600 lines, one every 100 ms.
  static void scan_a_minute(Reporter& reporter) {
    reporter.phase("scan", "");
    for (int i = 1; i <= 600; ++i) {
      g_now += milliseconds(100);
      reporter.progress("scan", {double(i), 600, "lines", 1000.0 * i});
    }
  }

  std::ostringstream out, talk;
};

TEST_F(ReporterTest, WithoutATerminalOneLinePerPhaseAndOneInTenSeconds) {
  {
    Reporter reporter = make({}, false);
    scan_a_minute(reporter);
  }
  const std::string text = talk.str();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1 + 6);
  EXPECT_THAT(text, Not(HasSubstr("\r")));
  EXPECT_THAT(text, Not(HasSubstr("\x1b")));
  EXPECT_THAT(text, HasSubstr("scan: 100 of 600 lines, 50 s left"));
  EXPECT_EQ(out.str(), "");
}

TEST_F(ReporterTest, OnATerminalABarThatIsWipedAway) {
  {
    Reporter reporter = make({}, true);
    scan_a_minute(reporter);
    reporter.say("done");
  }
  EXPECT_THAT(talk.str(), HasSubstr("\r"));
  EXPECT_THAT(talk.str(), HasSubstr("50 %"));
  EXPECT_THAT(talk.str(), ::testing::EndsWith(" \rdone\n"));
}

TEST_F(ReporterTest, PlainMeansNoCarriageReturnEvenOnATerminal) {
  ReportOptions options;
  options.plain = true;
  Reporter reporter = make(options, true);
  scan_a_minute(reporter);
  EXPECT_THAT(talk.str(), Not(HasSubstr("\r")));
}

TEST_F(ReporterTest, QuietKeepsWarningsAndErrors) {
  ReportOptions options;
  options.quiet = true;
  Reporter reporter = make(options, false);
  scan_a_minute(reporter);
  reporter.note("nothing much");
  EXPECT_EQ(talk.str(), "");
  reporter.warning("careful");
  reporter.error(Failure(kExitDevice, "It broke.", "Mend it."));
  EXPECT_EQ(talk.str(), "Note: careful\nreseau: It broke.\n  Try: Mend it.\n");
}

TEST_F(ReporterTest, EventsBeginWithTheSchemaAndNameRowsAndEta) {
  ReportOptions options;
  options.json = true;
  Reporter reporter = make(options, false);
  scan_a_minute(reporter);
  const auto list = events();
  ASSERT_GT(list.size(), 10U);
  EXPECT_EQ(list[0]["schema"], "reseau-events/1");
  EXPECT_EQ(list[1]["event"], "phase");
  EXPECT_EQ(list[1]["phase"], "scan");
  EXPECT_LE(list.size(), 2U + 301U);  // five a second at most
  const auto& last = list.back();
  EXPECT_EQ(last["event"], "progress");
  EXPECT_EQ(last["rows_done"], 600);
  EXPECT_EQ(last["rows"], 600);
  EXPECT_EQ(last["bytes"], 600000);
  EXPECT_EQ(last["eta_s"], 0.0);
  EXPECT_TRUE(list[2]["eta_s"].is_null());  // nothing to go by yet
  for (std::size_t i = 1; i < list.size(); ++i) EXPECT_TRUE(list[i].contains("t"));
}

TEST_F(ReporterTest, AnErrorEventHasCodeMessageAndTry) {
  ReportOptions options;
  options.json = true;
  Reporter reporter = make(options, false);
  reporter.error(Failure(kExitNoFilm, "No film.", "Insert some."));
  const auto event = events().back();
  EXPECT_EQ(event["event"], "error");
  EXPECT_EQ(event["code"], "no-film");
  EXPECT_EQ(event["exit"], 7);
  EXPECT_EQ(event["message"], "No film.");
  EXPECT_EQ(event["try"], "Insert some.");
}

TEST_F(ReporterTest, ResultsOfVerbsWithTheirOwnJson) {
  ReportOptions options;
  options.json_result = true;
  Reporter reporter = make(options, false);
  reporter.result_line("for people");
  reporter.result_json({{"schema", "reseau-x/1"}});
  EXPECT_EQ(out.str(), "{\"schema\":\"reseau-x/1\"}\n");
}

TEST_F(ReporterTest, ANameThatIsNoUtf8DoesNoHarm) {
  ReportOptions options;
  options.json = true;
  Reporter reporter = make(options, false);
  reporter.event("file", {{"path", "scans/\xff\xfe.tif"}});
  EXPECT_EQ(events().back()["event"], "file");
}

TEST_F(ReporterTest, BackgroundWorkIsNotShown) {
  ReportOptions options;
  options.json = true;
  Reporter reporter = make(options, false);
  reporter.phase("scan", "");
  reporter.phase("register", "", true);
  reporter.progress("register", {1, 2, "lines", 0});
  EXPECT_THAT(talk.str(), Not(HasSubstr("register")));
  EXPECT_EQ(events().back()["phase"], "register");
}

TEST(ReporterText, HumanNumbers) {
  EXPECT_EQ(human_seconds(0.2), "1 s");
  EXPECT_EQ(human_seconds(250), "4 min 10 s");
  EXPECT_EQ(human_seconds(3900), "1 h 05 min");
  EXPECT_EQ(human_bytes(188.1e6), "188.1 MB");
  EXPECT_FALSE(eta_seconds(0, 100, 10).has_value());
  EXPECT_FALSE(eta_seconds(50, 100, 0.1).has_value());
  EXPECT_DOUBLE_EQ(*eta_seconds(25, 100, 10), 30);
  EXPECT_FALSE(eta_seconds(std::numeric_limits<double>::quiet_NaN(), 100, 10).has_value());
}

}  // namespace
}  // namespace reseau::cli
