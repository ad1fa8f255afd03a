#include "capture/session/queued_sink.h"

#include <algorithm>

#include "core/base/check.h"

namespace reseau {

QueuedSink::QueuedSink(LineSink& downstream, int n_slots) : downstream_(downstream) {
  CHECK(n_slots >= 1);
  slots_.resize(static_cast<std::size_t>(n_slots));
}

QueuedSink::~QueuedSink() { end(ScanEnd::kFailed); }

void QueuedSink::begin(const LineFormat& format, const CaptureContext& context) {
  CHECK(!writer_.joinable());
  writer_ = std::jthread([this, format, context] { write_all(format, context); });
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return begun_; });
  if (error_) std::rethrow_exception(error_);
}

void QueuedSink::lines(const LineBlock& block) {
  std::unique_lock lock(mutex_);
  CHECK(begun_ && !end_);
  if (waiting_ == slots_.size() && !error_) {
    ++stats_.n_stalls;
    const auto since = std::chrono::steady_clock::now();
    changed_.wait(lock, [this] { return waiting_ < slots_.size() || error_; });
    stats_.stalled +=
        std::chrono::duration_cast<Duration>(std::chrono::steady_clock::now() - since);
  }
  if (error_) std::rethrow_exception(error_);
  LineBlock& slot = slots_[(first_ + waiting_) % slots_.size()];
  // The writer never touches a slot outside [first, first + waiting), so the copy needs no lock.
  lock.unlock();
  slot.first_line = block.first_line;
  slot.n_lines = block.n_lines;
  slot.width_px = block.width_px;
  slot.n_channels = block.n_channels;
  const auto used = block.used();
  slot.samples.assign(used.begin(), used.end());
  lock.lock();
  ++waiting_;
  ++stats_.n_blocks;
  stats_.most_waiting = std::max(stats_.most_waiting, static_cast<int>(waiting_));
  changed_.notify_all();
}

void QueuedSink::end(ScanEnd end) noexcept {
  if (!writer_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    end_ = end;
    changed_.notify_all();
  }
  writer_.join();
}

std::exception_ptr QueuedSink::error() const {
  const std::lock_guard lock(mutex_);
  return error_;
}

QueueStats QueuedSink::stats() const {
  const std::lock_guard lock(mutex_);
  return stats_;
}

void QueuedSink::write_all(const LineFormat& format, const CaptureContext& context) noexcept {
  std::exception_ptr failure;
  try {
    downstream_.begin(format, context);
  } catch (...) {
    failure = std::current_exception();
  }
  std::unique_lock lock(mutex_);
  begun_ = true;
  error_ = failure;
  changed_.notify_all();
  if (failure) return;
  while (true) {
    changed_.wait(lock, [this] { return waiting_ > 0 || end_; });
    if (waiting_ == 0 || error_) break;
    const LineBlock& block = slots_[first_];
    lock.unlock();
    try {
      downstream_.lines(block);
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    first_ = (first_ + 1) % slots_.size();
    --waiting_;
    if (failure) {
      error_ = failure;
      break;
    }
    changed_.notify_all();
  }
  changed_.notify_all();
  // After a failure nothing more is written; the caller learns of it from lines() and then ends.
  changed_.wait(lock, [this] { return end_.has_value(); });
  const ScanEnd end = error_ ? ScanEnd::kFailed : *end_;
  lock.unlock();
  downstream_.end(end);
}

}  // namespace reseau
