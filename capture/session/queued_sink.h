// Between the device thread and the disk: a bounded ring of blocks with a writer thread behind it.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "core/base/clock.h"
#include "core/line/line_sink.h"

namespace reseau {

// How often the disk made the scanner wait.
struct QueueStats {
  int n_blocks = 0;
  int n_stalls = 0;      // lines() found the ring full
  Duration stalled{};    // time that lines() waited for room
  int most_waiting = 0;  // blocks in the ring at the worst moment
};

// A LineSink decorator. begin, lines and end are called by one thread (the device thread); all
// calls of the sink behind it come from the writer thread that this class owns. A block is copied,
// so the caller may refill it at once; slots are reused, so nothing allocates after the ring went
// round once. No block is ever dropped: a full ring makes lines() wait, which delays the next READ.
//
// An exception of the sink behind reaches the caller from the next lines(), or through error() when
// it came while the ring drained. The sink behind gets exactly one end() once its begin() returned.
class QueuedSink final : public LineSink {
 public:
  // `downstream` outlives this. n_slots >= 1.
  QueuedSink(LineSink& downstream, int n_slots);
  // Ends as kFailed when nobody called end().
  ~QueuedSink() override;
  QueuedSink(const QueuedSink&) = delete;
  QueuedSink& operator=(const QueuedSink&) = delete;

  // Returns when the sink behind has begun; throws what it threw.
  void begin(const LineFormat& format, const CaptureContext& context) override;
  void lines(const LineBlock& block) override;
  // Returns when the ring is empty and the sink behind has ended. A sink that failed is told
  // kFailed whatever the caller says.
  void end(ScanEnd end) noexcept override;

  // What the sink behind threw; null when nothing. Meaningful after end().
  [[nodiscard]] std::exception_ptr error() const;
  [[nodiscard]] QueueStats stats() const;

 private:
  void write_all(const LineFormat& format, const CaptureContext& context) noexcept;

  LineSink& downstream_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<LineBlock> slots_;
  std::size_t first_ = 0;    // oldest waiting block
  std::size_t waiting_ = 0;  // blocks in the ring, the one being written included
  bool begun_ = false;       // begin() of the sink behind has returned or thrown
  std::optional<ScanEnd> end_;
  std::exception_ptr error_;
  QueueStats stats_;
  std::jthread writer_;
};

}  // namespace reseau
