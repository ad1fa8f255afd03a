#pragma once

#include <condition_variable>
#include <mutex>
#include <stop_token>

namespace reseau {

// How many lines of a file can be read: raised by the one who writes it, waited for by those who
// read. Thread-safe.
class LineWatermark {
 public:
  // Never falls; wakes the waiting.
  void raise_to(int n_lines);
  // No more lines will come.
  void close();

  [[nodiscard]] int committed() const;
  // As LineSource::wait_committed.
  int wait(int n_lines, const std::stop_token& stop) const;

 private:
  mutable std::mutex mutex_;
  mutable std::condition_variable_any changed_;
  int committed_ = 0;
  bool closed_ = false;
};

}  // namespace reseau
