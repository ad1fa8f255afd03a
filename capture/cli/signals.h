// Ctrl-C and SIGTERM as stop requests: the first ends the work at the next safe point, the second
// skips what can be done later, the third leaves at once. The same signal within 100 ms counts
// once.
#pragma once

#include <atomic>
#include <stop_token>
#include <thread>

namespace reseau::cli {

// Create it in main before any other thread: it blocks the signals for every thread started later
// and waits for them on its own. SIGPIPE and SIGXFSZ become errors of the write that caused them.
class SignalWatcher {
 public:
  SignalWatcher();
  ~SignalWatcher();
  SignalWatcher(const SignalWatcher&) = delete;
  SignalWatcher& operator=(const SignalWatcher&) = delete;

  // Requested by the first signal.
  [[nodiscard]] std::stop_token stop() const { return first_.get_token(); }
  // Requested by the second.
  [[nodiscard]] std::stop_token hurry() const { return second_.get_token(); }
  [[nodiscard]] int count() const { return count_; }

 private:
  void watch() noexcept;

  std::stop_source first_;
  std::stop_source second_;
  std::atomic<int> count_ = 0;
  int wake_fd_ = -1;
  int signal_fd_ = -1;
  std::jthread thread_;
};

}  // namespace reseau::cli
