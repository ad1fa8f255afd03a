// A scanner and a master in memory whose every step a test can steer.
#pragma once

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "capture/session/scan_session.h"
#include "drivers/scanner.h"

namespace reseau::testing {

// Sample of line y, channel c, pixel x: readable in a failure message.
inline std::uint16_t sample_at(int y, int c, int x) {
  return static_cast<std::uint16_t>(y * 100 + c * 10 + x);
}

inline LineFormat small_format(int n_lines) {
  LineFormat format;
  format.width_px = 3;
  format.n_lines = n_lines;
  format.channels = {Channel::kRed, Channel::kGreen};
  return format;
}

inline LineBlock make_block(const LineFormat& format, int first, int n) {
  LineBlock block;
  block.first_line = first;
  block.n_lines = n;
  block.width_px = format.width_px;
  block.n_channels = format.n_channels();
  for (int y = first; y < first + n; ++y) {
    for (int c = 0; c < format.n_channels(); ++c) {
      for (int x = 0; x < format.width_px; ++x) block.samples.push_back(sample_at(y, c, x));
    }
  }
  return block;
}

// Time that passes a second whenever someone looks.
class HurriedClock final : public Clock {
 public:
  TimePoint now() const override { return TimePoint(Duration(1'000'000 * ++looks_)); }
  void sleep_until(TimePoint) override {}

 private:
  mutable std::atomic<long> looks_ = 0;
};

class FakeScanner final : public Scanner {
 public:
  explicit FakeScanner(LineFormat format) : format_(std::move(format)) {}

  const Capabilities& capabilities() const override { return capabilities_; }
  Negotiated negotiate(const ScanRequest&) const override {
    Negotiated negotiated;
    negotiated.plan.format = format_;
    return negotiated;
  }
  bool start(const ScanPlan&, ScanObserver& observer, const std::stop_token& stop) override {
    observer.phase(ScanPhase::kFocus, "");
    if (on_start) on_start();
    return !stop.stop_requested();
  }
  const CaptureContext& context() const override { return context_; }
  ReadStatus read(LineBlock& block, Duration) override {
    if (on_read) {
      if (const auto status = on_read(next_, block)) return *status;
    }
    if (next_ >= format_.n_lines) return ReadStatus::kEndOfScan;
    const int n = std::min(lines_per_read, format_.n_lines - next_);
    block = make_block(format_, next_, n);
    next_ += n;
    return ReadStatus::kLines;
  }
  void stop() noexcept override { ++n_stops; }

  std::function<void()> on_start;
  // Called before each read with the next line; a value replaces what read() would do.
  std::function<std::optional<ReadStatus>(int, LineBlock&)> on_read;
  int lines_per_read = 2;
  int n_stops = 0;

 private:
  LineFormat format_;
  Capabilities capabilities_;
  CaptureContext context_;
  int next_ = 0;
};

// A master in memory: sink and source.
class FakeMaster final : public LineSink {
 public:
  class Source final : public LineSource {
   public:
    const LineFormat& format() const override { return format_; }
    int committed() const override {
      const std::lock_guard lock(mutex_);
      return lines_;
    }
    int wait_committed(int n_lines, const std::stop_token& stop) const override {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, stop, [&] { return lines_ >= n_lines || closed_; });
      return lines_;
    }
    void read(int first, int n, std::span<std::uint16_t> out) const override {
      const std::lock_guard lock(mutex_);
      const auto per_line = format_.samples_per_line();
      const auto from = static_cast<std::size_t>(first) * per_line;
      for (std::size_t i = 0; i < static_cast<std::size_t>(n) * per_line; ++i) {
        out[i] = samples_.at(from + i);
      }
    }
    LineFormat format_;
    mutable std::mutex mutex_;
    mutable std::condition_variable_any changed_;
    int lines_ = 0;
    bool closed_ = false;
    std::vector<std::uint16_t> samples_;
  };

  void begin(const LineFormat& format, const CaptureContext& context) override {
    calls.push_back("begin");
    if (on_begin) on_begin();
    source->format_ = format;
    seen_context = context;
  }
  void lines(const LineBlock& block) override {
    if (on_lines) on_lines(block);
    const std::lock_guard lock(source->mutex_);
    const auto used = block.used();
    source->samples_.insert(source->samples_.end(), used.begin(), used.end());
    source->lines_ += block.n_lines;
    source->changed_.notify_all();
  }
  void end(ScanEnd end) noexcept override {
    calls.push_back(end == ScanEnd::kComplete    ? "complete"
                    : end == ScanEnd::kCancelled ? "cancelled"
                                                 : "failed");
    const std::lock_guard lock(source->mutex_);
    source->closed_ = true;
    source->changed_.notify_all();
  }

  std::shared_ptr<Source> source = std::make_shared<Source>();
  CaptureContext seen_context;
  std::vector<std::string> calls;  // begin and end only
  std::function<void()> on_begin;
  std::function<void(const LineBlock&)> on_lines;
};

class SilentObserver final : public SessionObserver {
 public:
  void phase(ScanPhase, const std::string&) override {}
  void note(const std::string&) override {}
  void began(const LineFormat&, const CaptureContext&) override { ++n_began; }
  void progress(int lines_read, int, int) override { last_read = lines_read; }
  int n_began = 0;
  int last_read = 0;
};

}  // namespace reseau::testing
