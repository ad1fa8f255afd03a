#include "core/base/parallel.h"

#ifdef RESEAU_PLAIN_THREADS
#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>
#else
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#endif

namespace reseau {

#ifdef RESEAU_PLAIN_THREADS

namespace {
int all_cores() { return std::max(2, static_cast<int>(std::thread::hardware_concurrency())); }
thread_local int thread_limit = 0;  // 0 = all cores
}  // namespace

void parallel_for(int n, const std::function<void(int)>& body) {
  std::atomic<int> next{0};
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const auto work = [&] {
    for (int i = next++; i < n; i = next++) {
      try {
        body(i);
      } catch (...) {
        const std::scoped_lock lock(failure_mutex);
        if (!failure) failure = std::current_exception();
        next = n;
      }
    }
  };
  const int n_threads = std::min(thread_limit > 0 ? thread_limit : all_cores(), n);
  std::vector<std::thread> others;
  for (int t = 1; t < n_threads; ++t) {
    others.emplace_back([&] {
      thread_limit = 1;  // what is nested stays on this thread
      work();
    });
  }
  work();
  for (std::thread& other : others) other.join();
  if (failure) std::rethrow_exception(failure);
}

void with_threads(int n_threads, const std::function<void()>& work) {
  const int before = thread_limit;
  thread_limit = n_threads;
  try {
    work();
  } catch (...) {
    thread_limit = before;
    throw;
  }
  thread_limit = before;
}

#else

void parallel_for(int n, const std::function<void(int)>& body) {
  tbb::parallel_for(0, n, [&](int i) { body(i); });
}

void with_threads(int n_threads, const std::function<void()>& work) {
  tbb::task_arena arena(n_threads > 0 ? n_threads : tbb::task_arena::automatic);
  arena.execute(work);
}

#endif

}  // namespace reseau
