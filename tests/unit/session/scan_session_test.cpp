#include "capture/session/scan_session.h"

#include <cerrno>
#include <string>
#include <system_error>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "tests/unit/session/fake_scan.h"

namespace reseau {
namespace {

using ::testing::ElementsAre;
using testing::FakeMaster;
using testing::FakeScanner;
using ::testing::HasSubstr;
using testing::HurriedClock;
using ::testing::IsEmpty;
using testing::make_block;
using testing::SilentObserver;
using testing::small_format;

std::string message(const std::exception_ptr& error) {
  if (!error) return "";
  try {
    std::rethrow_exception(error);
  } catch (const std::exception& exception) {
    return exception.what();
  }
}

class ScanSessionTest : public ::testing::Test {
 protected:
  ScanOutcome run(const std::stop_token& stop = {}) {
    ScanPlan plan;
    plan.format = format;
    ScanSession session(
        scanner, plan, master, [this] { return master.source; }, observer, options);
    return session.run(stop);
  }

  LineFormat format = small_format(21);
  FakeScanner scanner{format};
  FakeMaster master;
  SilentObserver observer;
  SessionOptions options;
  HurriedClock clock;
};

TEST_F(ScanSessionTest, EveryLineReachesTheMaster) {
  const ScanOutcome outcome = run();
  EXPECT_EQ(outcome.end, ScanEnd::kComplete);
  EXPECT_EQ(outcome.lines, 21);
  EXPECT_EQ(outcome.error, nullptr);
  EXPECT_TRUE(outcome.began);
  EXPECT_THAT(master.calls, ElementsAre("begin", "complete"));
  EXPECT_EQ(master.source->samples_, make_block(format, 0, 21).samples);
  EXPECT_GE(scanner.n_stops, 1);
  EXPECT_EQ(observer.n_began, 1);
  EXPECT_EQ(observer.last_read, 21);
}

TEST_F(ScanSessionTest, DevelopSeesAllLinesAndFinishesBeforeRunReturns) {
  int seen = 0;
  options.develop = [&](const LineSource& lines, const CaptureContext&,
                        const std::stop_token& stop) { seen = lines.wait_committed(21, stop); };
  EXPECT_EQ(run().end, ScanEnd::kComplete);
  EXPECT_EQ(seen, 21);
}

TEST_F(ScanSessionTest, DevelopIsStoppedWhenTheScanBreaksOff) {
  scanner.on_read = [](int next, LineBlock&) -> std::optional<ReadStatus> {
    if (next >= 8) throw DeviceError(DeviceError::Kind::kDisconnected, "gone", "");
    return std::nullopt;
  };
  options.develop = [](const LineSource&, const CaptureContext&, const std::stop_token& stop) {
    while (!stop.stop_requested()) std::this_thread::yield();
  };
  EXPECT_EQ(run().lines, 8);
}

TEST_F(ScanSessionTest, DevelopIsStoppedWhenTheCallerWishes) {
  std::stop_source source;
  options.develop_stop = source.get_token();
  options.develop = [&](const LineSource& lines, const CaptureContext&,
                        const std::stop_token& stop) {
    static_cast<void>(lines.wait_committed(21, stop));
    source.request_stop();
    EXPECT_TRUE(stop.stop_requested());
  };
  EXPECT_EQ(run().end, ScanEnd::kComplete);
}

TEST_F(ScanSessionTest, ADevelopErrorHarmsNothing) {
  options.develop = [](const LineSource&, const CaptureContext&, const std::stop_token&) {
    throw std::runtime_error("no colours");
  };
  const ScanOutcome outcome = run();
  EXPECT_EQ(outcome.end, ScanEnd::kComplete);
  EXPECT_EQ(message(outcome.develop_error), "no colours");
  EXPECT_EQ(outcome.lines, 21);
}

TEST_F(ScanSessionTest, UnplugKeepsEveryLineThatWasRead) {
  scanner.on_read = [](int next, LineBlock&) -> std::optional<ReadStatus> {
    if (next >= 8) throw DeviceError(DeviceError::Kind::kDisconnected, "gone", "");
    return std::nullopt;
  };
  int seen = -1;
  options.develop = [&](const LineSource& lines, const CaptureContext&,
                        const std::stop_token& stop) { seen = lines.wait_committed(21, stop); };
  const ScanOutcome outcome = run();
  EXPECT_EQ(outcome.end, ScanEnd::kFailed);
  EXPECT_EQ(message(outcome.error), "gone");
  EXPECT_EQ(outcome.lines, 8);
  EXPECT_EQ(seen, 8);  // develop was told that no more will come
  EXPECT_THAT(master.calls, ElementsAre("begin", "failed"));
  EXPECT_EQ(master.source->samples_, make_block(format, 0, 8).samples);
  EXPECT_GE(scanner.n_stops, 1);
}

TEST_F(ScanSessionTest, CancelKeepsWhatWasRead) {
  std::stop_source source;
  scanner.on_read = [&](int next, LineBlock&) -> std::optional<ReadStatus> {
    if (next == 6) source.request_stop();
    return std::nullopt;
  };
  const ScanOutcome outcome = run(source.get_token());
  EXPECT_EQ(outcome.end, ScanEnd::kCancelled);
  EXPECT_EQ(outcome.error, nullptr);
  EXPECT_EQ(outcome.lines, 8);  // the block that was under way still arrives
  EXPECT_THAT(master.calls, ElementsAre("begin", "cancelled"));
}

TEST_F(ScanSessionTest, CancelBeforeTheScanOpensNoMaster) {
  std::stop_source source;
  source.request_stop();
  const ScanOutcome outcome = run(source.get_token());
  EXPECT_EQ(outcome.end, ScanEnd::kCancelled);
  EXPECT_FALSE(outcome.began);
  EXPECT_THAT(master.calls, IsEmpty());
  EXPECT_GE(scanner.n_stops, 1);
}

TEST_F(ScanSessionTest, AScannerThatCannotStartOpensNoMaster) {
  scanner.on_start = [] { throw DeviceError(DeviceError::Kind::kNoMedium, "no film", ""); };
  const ScanOutcome outcome = run();
  EXPECT_EQ(outcome.end, ScanEnd::kFailed);
  EXPECT_EQ(message(outcome.error), "no film");
  EXPECT_THAT(master.calls, IsEmpty());
  EXPECT_GE(scanner.n_stops, 1);
}

TEST_F(ScanSessionTest, AMasterThatCannotBeginStopsTheScanner) {
  master.on_begin = [] { throw std::system_error(EACCES, std::generic_category(), "scans"); };
  const ScanOutcome outcome = run();
  EXPECT_EQ(outcome.end, ScanEnd::kFailed);
  EXPECT_FALSE(outcome.began);
  EXPECT_THAT(message(outcome.error), HasSubstr("scans"));
  EXPECT_GE(scanner.n_stops, 1);
}

TEST_F(ScanSessionTest, AFullDiskStopsTheScannerAndKeepsTheCommittedLines) {
  master.on_lines = [](const LineBlock& block) {
    if (block.first_line >= 10) throw std::system_error(ENOSPC, std::generic_category(), "full");
  };
  const ScanOutcome outcome = run();
  EXPECT_EQ(outcome.end, ScanEnd::kFailed);
  EXPECT_THAT(message(outcome.error), HasSubstr("full"));
  EXPECT_EQ(outcome.lines, 10);
  EXPECT_THAT(master.calls, ElementsAre("begin", "failed"));
  EXPECT_GE(scanner.n_stops, 1);
}

TEST_F(ScanSessionTest, AnEarlyEndIsAnErrorAndKeepsTheLines) {
  scanner.on_read = [](int next, LineBlock&) -> std::optional<ReadStatus> {
    if (next >= 4) return ReadStatus::kEndOfScan;
    return std::nullopt;
  };
  const ScanOutcome outcome = run();
  EXPECT_EQ(outcome.end, ScanEnd::kFailed);
  EXPECT_THAT(message(outcome.error), HasSubstr("4 of 21 lines"));
  EXPECT_EQ(outcome.lines, 4);
}

TEST_F(ScanSessionTest, AGapInTheLinesIsRefused) {
  scanner.on_read = [this](int next, LineBlock& block) -> std::optional<ReadStatus> {
    if (next < 4) return std::nullopt;
    block = make_block(format, 5, 2);
    return ReadStatus::kLines;
  };
  const ScanOutcome outcome = run();
  EXPECT_EQ(outcome.end, ScanEnd::kFailed);
  EXPECT_THAT(message(outcome.error), HasSubstr("at line 4 of 21"));
  EXPECT_EQ(outcome.lines, 4);
}

TEST_F(ScanSessionTest, MoreLinesThanPlannedAreRefused) {
  scanner.on_read = [this](int next, LineBlock& block) -> std::optional<ReadStatus> {
    if (next < 20) return std::nullopt;
    block = make_block(format, 20, 2);
    return ReadStatus::kLines;
  };
  EXPECT_EQ(run().end, ScanEnd::kFailed);
  EXPECT_EQ(master.source->committed(), 20);
}

TEST_F(ScanSessionTest, ASilentScannerIsGivenUp) {
  options.clock = &clock;
  options.silence_limit = std::chrono::seconds(120);
  scanner.on_read = [](int next, LineBlock&) -> std::optional<ReadStatus> {
    if (next >= 2) return ReadStatus::kNotReady;
    return std::nullopt;
  };
  const ScanOutcome outcome = run();
  EXPECT_EQ(outcome.end, ScanEnd::kFailed);
  EXPECT_THAT(message(outcome.error), HasSubstr("nothing for 120 seconds"));
  EXPECT_EQ(outcome.lines, 2);
}

TEST_F(ScanSessionTest, NotReadyIsNoError) {
  bool waited = false;
  scanner.on_read = [&](int next, LineBlock&) -> std::optional<ReadStatus> {
    if (next != 10 || waited) return std::nullopt;
    waited = true;
    return ReadStatus::kNotReady;
  };
  EXPECT_EQ(run().end, ScanEnd::kComplete);
  EXPECT_TRUE(waited);
}

TEST_F(ScanSessionTest, TheMasterNamesTheDeviceOfTheRecording) {
  options.device_name = "sim:ls5000";
  options.started_at_utc = "2026-11-22T10:15:00Z";
  EXPECT_EQ(run().context.device_name, "sim:ls5000");
  EXPECT_EQ(master.seen_context.started_at_utc, "2026-11-22T10:15:00Z");
}

TEST_F(ScanSessionTest, AnyGroupingOfLinesGivesTheSameMaster) {
  for (const int lines_per_read : {1, 3, 7, 21, 50}) {
    for (const int slots : {1, 2, 16}) {
      FakeScanner one(format);
      one.lines_per_read = lines_per_read;
      FakeMaster to;
      SessionOptions with;
      with.ring_blocks = slots;
      ScanPlan plan;
      plan.format = format;
      ScanSession session(
          one, plan, to, [&to] { return to.source; }, observer, with);
      EXPECT_EQ(session.run({}).end, ScanEnd::kComplete);
      EXPECT_EQ(to.source->samples_, make_block(format, 0, 21).samples)
          << lines_per_read << " lines at a time, " << slots << " slots";
    }
  }
}

}  // namespace
}  // namespace reseau
