#include "capture/store/line_watermark.h"

#include <algorithm>

namespace reseau {

void LineWatermark::raise_to(int n_lines) {
  {
    const std::lock_guard lock(mutex_);
    committed_ = std::max(committed_, n_lines);
  }
  changed_.notify_all();
}

void LineWatermark::close() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  changed_.notify_all();
}

int LineWatermark::committed() const {
  const std::lock_guard lock(mutex_);
  return committed_;
}

int LineWatermark::wait(int n_lines, const std::stop_token& stop) const {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, stop, [&] { return committed_ >= n_lines || closed_; });
  return committed_;
}

}  // namespace reseau
