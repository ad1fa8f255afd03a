// The provisional picture of a scan whose lines are still coming.
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "core/line/line_source.h"
#include "core/reconstruct/live_tile_sink.h"
#include "core/reconstruct/reconstruct.h"

namespace reseau {

class Rendering;

struct LiveReport {
  int lock_lines = 0;  // committed when the first map came; 0: none came
  int n_tiles = 0;
  int n_lines = 0;  // that were handed out
  int n_maps = 0;   // that were used
  // Committed lines beyond the last one that was handed out, at the worst moment, once those from
  // before the lock had been.
  int largest_lag_lines = 0;
  std::string why_not;  // a sentence, where it ended early by an error
};

// Renders at draft quality, on a thread of its own, whatever lines are committed: with the newest
// map, and with the sharpness of the lines so far, measured at the lock and again each time that
// their number has doubled. Nothing of it goes into the final picture. Memory is that of a few
// bands of lines.
class LivePicture {
 public:
  // Starts the thread. Source and sink must outlive this. Of the options quality, deconvolution and
  // frame are its own: draft, none, the scan's.
  LivePicture(const LineSource& source, const ReconstructOptions& options, LiveTileSink& sink);
  // Stops, and waits until the sink has returned.
  ~LivePicture() = default;
  LivePicture(const LivePicture&) = delete;
  LivePicture& operator=(const LivePicture&) = delete;
  LivePicture(LivePicture&&) = delete;
  LivePicture& operator=(LivePicture&&) = delete;

  // The newest map, which takes the place of the one before. Thread-safe, returns at once.
  void take(std::shared_ptr<const RegistrationSnapshot> snapshot);
  // Begins no more tiles. Thread-safe, returns at once.
  void stop();
  // So far. Thread-safe.
  [[nodiscard]] LiveReport report() const;

 private:
  void run(const std::stop_token& stop) noexcept;
  void paint(const std::stop_token& stop);
  // From the first lines.
  [[nodiscard]] std::unique_ptr<const Rendering> measure(int n_lines,
                                                         const RegistrationSnapshot& snapshot,
                                                         const std::stop_token& stop) const;
  // Lines [first, end) with everything about them that is there; hands out the tiles. Returns how
  // many lines were committed just before.
  int paint_band(int first, int end, const Rendering& rendering,
                 const RegistrationSnapshot& snapshot, const std::stop_token& stop);
  // The first map; null on a stop request.
  [[nodiscard]] std::shared_ptr<const RegistrationSnapshot> wait_for_map(
      const std::stop_token& stop);
  [[nodiscard]] std::shared_ptr<const RegistrationSnapshot> newest() const;

  const LineSource& source_;
  ReconstructOptions options_;
  LiveTileSink& sink_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::shared_ptr<const RegistrationSnapshot> snapshot_;
  LiveReport report_;
  std::vector<std::vector<float>> pixels_;  // of a band, tile by tile
  std::jthread thread_;                     // last: it uses all others
};

}  // namespace reseau
