// Between those who make a picture and the disk: rows wait in memory while files are written.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <exception>
#include <mutex>
#include <span>
#include <thread>
#include <vector>

#include "core/base/clock.h"
#include "core/reconstruct/row_sink.h"

namespace reseau {

// An RgbRowSink decorator, as QueuedSink is for lines: rows() copies and returns, a thread of its
// own writes. At most kMostWaiting pieces wait; then rows() does. Calls come from one thread. What
// the sink behind throws comes from the next rows() or from end().
class QueuedRows final : public RgbRowSink {
 public:
  static constexpr std::size_t kMostWaiting = 3;

  // `to` outlives this. The thread calls its rows(); begin() and end() are called as they come,
  // before the first and after the last.
  explicit QueuedRows(RgbRowSink& to) : to_(to) {}
  // Waits for the piece that is being written; what waits behind it is dropped.
  ~QueuedRows() override = default;
  QueuedRows(const QueuedRows&) = delete;
  QueuedRows& operator=(const QueuedRows&) = delete;

  void begin(int width_px, int height_px) override;
  void rows(int first_row, int n_rows, std::span<const float> rgb) override;
  void end() override;

  // When end() was called: all rows had been made. Valid after end().
  [[nodiscard]] TimePoint made_at() const { return made_at_; }

 private:
  struct Piece {
    int first_row = 0, n_rows = 0;
    std::vector<float> rgb;
  };
  void write(const std::stop_token& stop) noexcept;
  void rethrow() const;

  RgbRowSink& to_;
  TimePoint made_at_{};
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<Piece> waiting_;  // the first is being written
  std::vector<float> spare_;   // of a piece that was written
  std::exception_ptr error_;
  std::jthread thread_;  // last: it uses all others
};

}  // namespace reseau
