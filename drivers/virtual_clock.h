#pragma once

#include <atomic>

#include "core/base/clock.h"

namespace reseau {

// Time that passes only when someone waits for it or a recording says so: a simulated or replayed
// unit makes nobody wait. Thread-safe.
class VirtualClock final : public Clock {
 public:
  [[nodiscard]] TimePoint now() const override { return TimePoint(Duration(now_us_.load())); }
  void sleep_until(TimePoint when) override { advance_to(when); }

  // Never goes back.
  void advance_to(TimePoint when) {
    const auto target_us = when.time_since_epoch().count();
    auto current_us = now_us_.load();
    while (current_us < target_us && !now_us_.compare_exchange_weak(current_us, target_us)) {
    }
  }

 private:
  std::atomic<Duration::rep> now_us_{0};
};

}  // namespace reseau
