#include "capture/session/queued_rows.h"

#include <stop_token>
#include <utility>

namespace reseau {

void QueuedRows::begin(int width_px, int height_px) {
  to_.begin(width_px, height_px);
  thread_ = std::jthread([this](const std::stop_token& stop) noexcept { write(stop); });
}

void QueuedRows::rethrow() const {
  if (error_) std::rethrow_exception(error_);
}

void QueuedRows::rows(int first_row, int n_rows, std::span<const float> rgb) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return waiting_.size() < kMostWaiting || error_; });
  rethrow();
  Piece piece{first_row, n_rows, std::exchange(spare_, {})};
  lock.unlock();
  piece.rgb.assign(rgb.begin(), rgb.end());
  lock.lock();
  waiting_.push_back(std::move(piece));
  changed_.notify_all();
}

void QueuedRows::end() {
  {
    std::unique_lock lock(mutex_);
    made_at_ = SystemClock().now();
    changed_.wait(lock, [this] { return waiting_.empty() || error_; });
    rethrow();
  }
  to_.end();
}

void QueuedRows::write(const std::stop_token& stop) noexcept {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [this] { return !waiting_.empty(); })) {
    if (stop.stop_requested()) return;
    const Piece& piece = waiting_.front();  // stays where it is while others are added behind it
    lock.unlock();
    std::exception_ptr error;
    try {
      to_.rows(piece.first_row, piece.n_rows, piece.rgb);
    } catch (...) {
      error = std::current_exception();
    }
    lock.lock();
    error_ = error;
    spare_ = std::move(waiting_.front().rgb);
    waiting_.pop_front();
    changed_.notify_all();
    if (error_) return;
  }
}

}  // namespace reseau
