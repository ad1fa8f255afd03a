#include "capture/session/queued_sink.h"

#include <cerrno>
#include <future>
#include <latch>
#include <system_error>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/session/fake_scan.h"

namespace reseau {
namespace {

using ::testing::ElementsAre;
using testing::FakeMaster;
using testing::make_block;
using testing::small_format;

TEST(QueuedSink, DeliversEveryLineInOrder) {
  FakeMaster master;
  const LineFormat format = small_format(101);
  QueuedSink queue(master, 3);
  queue.begin(format, {});
  for (int y = 0; y < 101; ++y) queue.lines(make_block(format, y, 1));
  queue.end(ScanEnd::kComplete);
  EXPECT_EQ(queue.stats().n_blocks, 101);
  EXPECT_LE(queue.stats().most_waiting, 3);
  EXPECT_EQ(queue.error(), nullptr);
  EXPECT_THAT(master.calls, ElementsAre("begin", "complete"));
  EXPECT_EQ(master.source->samples_, make_block(format, 0, 101).samples);
}

TEST(QueuedSink, TheBlockMayBeRefilledAtOnce) {
  FakeMaster master;
  const LineFormat format = small_format(8);
  QueuedSink queue(master, 8);
  queue.begin(format, {});
  for (int y = 0; y < 8; ++y) {
    LineBlock block = make_block(format, y, 1);
    queue.lines(block);
    std::fill(block.samples.begin(), block.samples.end(), std::uint16_t{9999});
  }
  queue.end(ScanEnd::kComplete);
  EXPECT_EQ(master.source->samples_, make_block(format, 0, 8).samples);
}

TEST(QueuedSink, AFullRingMakesTheCallerWaitAndIsCounted) {
  FakeMaster master;
  std::latch disk_is_slow(1);
  master.on_lines = [&](const LineBlock& block) {
    if (block.first_line == 0) disk_is_slow.wait();
  };
  const LineFormat format = small_format(4);
  QueuedSink queue(master, 2);
  queue.begin(format, {});
  queue.lines(make_block(format, 0, 1));
  queue.lines(make_block(format, 1, 1));
  auto third = std::async(std::launch::async, [&] { queue.lines(make_block(format, 2, 1)); });
  // The stall is counted before lines() waits, so this ends.
  while (queue.stats().n_stalls == 0) std::this_thread::yield();
  disk_is_slow.count_down();
  third.get();
  queue.lines(make_block(format, 3, 1));
  queue.end(ScanEnd::kComplete);
  EXPECT_EQ(master.source->samples_, make_block(format, 0, 4).samples);
}

TEST(QueuedSink, BeginThrowsWhatTheSinkThrewAndNeverEndsIt) {
  FakeMaster master;
  master.on_begin = [] { throw std::runtime_error("no room"); };
  QueuedSink queue(master, 2);
  EXPECT_THROW(queue.begin(small_format(2), {}), std::runtime_error);
  queue.end(ScanEnd::kComplete);
  EXPECT_THAT(master.calls, ElementsAre("begin"));
}

TEST(QueuedSink, AWriteErrorReachesTheCallerAndTheSinkEndsAsFailed) {
  FakeMaster master;
  master.on_lines = [](const LineBlock& block) {
    if (block.first_line == 1) throw std::system_error(ENOSPC, std::generic_category());
  };
  const LineFormat format = small_format(1000);
  QueuedSink queue(master, 2);
  queue.begin(format, {});
  EXPECT_THROW(
      {
        for (int y = 0; y < 1000; ++y) queue.lines(make_block(format, y, 1));
      },
      std::system_error);
  queue.end(ScanEnd::kComplete);
  EXPECT_NE(queue.error(), nullptr);
  EXPECT_THAT(master.calls, ElementsAre("begin", "failed"));
  EXPECT_EQ(master.source->committed(), 1);
}

TEST(QueuedSink, AWriteErrorWhileDrainingIsNotLost) {
  FakeMaster master;
  master.on_lines = [](const LineBlock&) {
    throw std::system_error(ENOSPC, std::generic_category());
  };
  QueuedSink queue(master, 4);
  queue.begin(small_format(1), {});
  queue.lines(make_block(small_format(1), 0, 1));
  queue.end(ScanEnd::kComplete);
  EXPECT_NE(queue.error(), nullptr);
  EXPECT_THAT(master.calls, ElementsAre("begin", "failed"));
}

TEST(QueuedSink, ForgottenEndIsAFailedEnd) {
  FakeMaster master;
  {
    QueuedSink queue(master, 2);
    queue.begin(small_format(2), {});
    queue.lines(make_block(small_format(2), 0, 1));
  }
  EXPECT_THAT(master.calls, ElementsAre("begin", "failed"));
  EXPECT_EQ(master.source->committed(), 1);
}

TEST(QueuedSink, ASecondEndDoesNothing) {
  FakeMaster master;
  QueuedSink queue(master, 2);
  queue.begin(small_format(2), {});
  queue.end(ScanEnd::kCancelled);
  queue.end(ScanEnd::kFailed);
  EXPECT_THAT(master.calls, ElementsAre("begin", "cancelled"));
}

}  // namespace
}  // namespace reseau
