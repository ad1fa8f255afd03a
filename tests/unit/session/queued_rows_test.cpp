#include "capture/session/queued_rows.h"

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace reseau {
namespace {

// Says what it is told; writes only when it may, and fails at a row.
class SlowDisk final : public RgbRowSink {
 public:
  void begin(int width_px, int height_px) override {
    told += "begin " + std::to_string(width_px) + "x" + std::to_string(height_px) + "\n";
  }
  void rows(int first_row, int n_rows, std::span<const float> rgb) override {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return free_; });
    if (first_row == fails_at) throw std::runtime_error("The disk is full.");
    told += std::to_string(first_row) + "+" + std::to_string(n_rows) + " of " +
            std::to_string(rgb.front()) + "\n";
  }
  void end() override { told += "end\n"; }
  void let_go() {
    {
      const std::scoped_lock lock(mutex_);
      free_ = true;
    }
    changed_.notify_all();
  }
  std::string told;
  int fails_at = -1;

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool free_ = false;
};

std::vector<float> row(float value) { return std::vector<float>(6, value); }

TEST(QueuedRows, MakingGoesOnWhileTheDiskIsSlowAndEveryRowArrivesInOrder) {
  SlowDisk disk;
  QueuedRows queue(disk);
  queue.begin(2, 4);
  // The disk takes none yet.
  for (int y = 0; y < static_cast<int>(QueuedRows::kMostWaiting); ++y)
    queue.rows(y, 1, row(static_cast<float>(y)));
  disk.let_go();
  queue.rows(3, 1, row(3));
  queue.end();
  EXPECT_EQ(disk.told,
            "begin 2x4\n0+1 of 0.000000\n1+1 of 1.000000\n2+1 of 2.000000\n3+1 of 3.000000\nend\n");
}

TEST(QueuedRows, WhatTheDiskThrowsComesBackAndNothingIsEnded) {
  SlowDisk disk;
  disk.fails_at = 1;
  disk.let_go();
  QueuedRows queue(disk);
  queue.begin(2, 4);
  queue.rows(0, 1, row(0));
  EXPECT_THROW(
      {
        for (int y = 1; y < 100; ++y) queue.rows(y, 1, row(1));
        queue.end();
      },
      std::runtime_error);
  EXPECT_EQ(disk.told, "begin 2x4\n0+1 of 0.000000\n");
}

TEST(QueuedRows, LeavesWithoutAnEndWhenNobodyEndsIt) {
  SlowDisk disk;
  disk.let_go();
  {
    QueuedRows queue(disk);
    queue.begin(2, 4);
    queue.rows(0, 1, row(0));
  }
  EXPECT_EQ(disk.told.find("end"), std::string::npos);
}

}  // namespace
}  // namespace reseau
