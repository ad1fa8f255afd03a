// What the local page of a running scan shows: how far it is, and the picture so far, made smaller.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "capture/image/view_encoding.h"
#include "core/reconstruct/live_tile_sink.h"

namespace reseau {

// Takes tiles as they come and answers whoever asks, at any time and as often as they like: a slow
// browser holds up nobody, it sees fewer states in between. Memory is that of one picture of
// kMostSidePx. Thread-safe.
class LivePage final : public LiveTileSink {
 public:
  static constexpr int kMostSidePx = 1600;
  static constexpr int kStripRows = 64;

  explicit LivePage(const std::array<double, 9>& srgb_from_picture);

  void begin(int width_px, int height_px) override;
  void tile(const LiveTile& tile) override;

  // "waiting", "scanning", "finishing": what happens now.
  void set_phase(const std::string& phase);
  void set_lines(int n_committed, int n_lines);
  // The end: the files that there are (empty: none), and a sentence.
  void finish(const std::filesystem::path& view, const std::filesystem::path& receipt,
              const std::string& sentence);

  // {"schema": "reseau-live/1", …}; README.md.
  [[nodiscard]] std::string state_json() const;
  // Rows [kStripRows * strip, …) of the small picture as PNG; nothing where there is none.
  [[nodiscard]] std::optional<std::string> strip_png(int strip) const;
  [[nodiscard]] bool ended() const;
  [[nodiscard]] std::filesystem::path view() const;
  [[nodiscard]] std::filesystem::path receipt() const;

 private:
  [[nodiscard]] int n_strips() const { return (height_ + kStripRows - 1) / kStripRows; }
  void add(const LiveTile& tile);
  void choose_exposure();

  const std::array<double, 9> srgb_from_picture_;
  mutable std::mutex mutex_;
  std::string phase_ = "waiting", sentence_;
  int n_lines_ = 0, n_committed_ = 0, n_shown_ = 0, lag_lines_ = 0, map_lines_ = 0;
  bool ended_ = false;
  std::filesystem::path view_, receipt_;
  // The small picture: means of step_ x step_ pixels.
  int step_ = 1, scan_width_ = 0, width_ = 0, height_ = 0;
  std::vector<float> rgb_;
  std::vector<int> versions_;  // of the strips
  LuminanceHistogram luminances_;
  int exposure_step_ = 0;
};

}  // namespace reseau
