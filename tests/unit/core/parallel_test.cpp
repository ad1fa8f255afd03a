#include "core/base/parallel.h"

#include <atomic>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace reseau {
namespace {

TEST(Parallel, EveryIndexOnceAndNestedToo) {
  constexpr int kOuter = 37, kInner = 11;
  std::vector<int> count(kOuter * kInner, 0);
  parallel_for(kOuter, [&](int i) {
    parallel_for(kInner, [&](int j) { ++count[static_cast<std::size_t>(i * kInner + j)]; });
  });
  EXPECT_EQ(count, std::vector<int>(kOuter * kInner, 1));
}

TEST(Parallel, NothingToDoCallsNothing) {
  parallel_for(0, [](int) { FAIL(); });
}

TEST(Parallel, TheExceptionOfATaskReachesTheCaller) {
  std::string said;
  try {
    parallel_for(100, [](int i) {
      if (i == 42) throw std::runtime_error("the forty-second");
    });
  } catch (const std::runtime_error& error) {
    said = error.what();
  }
  EXPECT_EQ(said, "the forty-second");
}

TEST(Parallel, OneThreadIsTheCallers) {
  std::mutex mutex;
  std::set<std::thread::id> seen;
  with_threads(1, [&] {
    parallel_for(64, [&](int) {
      const std::scoped_lock lock(mutex);
      seen.insert(std::this_thread::get_id());
    });
  });
  EXPECT_EQ(seen.size(), 1U);
}

TEST(Parallel, AnExceptionLeavesWithThreads) {
  EXPECT_THROW(with_threads(2, [] { throw std::runtime_error("stop"); }), std::runtime_error);
  std::atomic<int> n{0};
  parallel_for(10, [&](int) { ++n; });
  EXPECT_EQ(n, 10);
}

}  // namespace
}  // namespace reseau
