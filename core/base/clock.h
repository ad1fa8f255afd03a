// The seam of time: whatever waits takes a Clock, so that a simulated or replayed device does not
// make anyone wait, and tests never sleep.
#pragma once

#include <chrono>
#include <thread>

namespace reseau {

using Duration = std::chrono::microseconds;
using TimePoint = std::chrono::time_point<std::chrono::steady_clock, Duration>;

// Thread-safe.
class Clock {
 public:
  virtual ~Clock() = default;
  [[nodiscard]] virtual TimePoint now() const = 0;
  // Returns at or after `when`; at once when it has passed.
  virtual void sleep_until(TimePoint when) = 0;

  void sleep_for(Duration duration) { sleep_until(now() + duration); }
};

class SystemClock final : public Clock {
 public:
  [[nodiscard]] TimePoint now() const override {
    return std::chrono::time_point_cast<Duration>(std::chrono::steady_clock::now());
  }
  void sleep_until(TimePoint when) override { std::this_thread::sleep_until(when); }
};

}  // namespace reseau
