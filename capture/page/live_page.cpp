#include "capture/page/live_page.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <nlohmann/json.hpp>

#include "capture/image/png_memory.h"

namespace reseau {
namespace {

// As view copies are exposed, but in steps: a picture that flickers is worse than one that is a
// sixth of a stop off.
constexpr double kWhitePercentile = 0.995;
constexpr double kStepsPerStop = 3;

}  // namespace

LivePage::LivePage(const std::array<double, 9>& srgb_from_picture)
    : srgb_from_picture_(srgb_from_picture), luminances_(srgb_from_picture) {}

void LivePage::begin(int width_px, int height_px) {
  const std::scoped_lock lock(mutex_);
  step_ = (std::max(width_px, height_px) + kMostSidePx - 1) / kMostSidePx;
  scan_width_ = width_px;
  n_lines_ = height_px;
  width_ = std::max(1, width_px / step_);
  height_ = std::max(1, height_px / step_);
  rgb_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_) * 3, 0.0F);
  versions_.assign(static_cast<std::size_t>(n_strips()), 0);
}

void LivePage::add(const LiveTile& tile) {
  const float share = 1.0F / static_cast<float>(step_ * step_);
  const float* from = tile.rgb.data();
  for (int y = tile.y_px; y < tile.y_px + tile.height_px; ++y) {
    if (y / step_ >= height_) return;  // less than a row of the small picture
    float* row = &rgb_[static_cast<std::size_t>(y / step_) * static_cast<std::size_t>(width_) * 3];
    for (int x = tile.x_px; x < tile.x_px + tile.width_px; ++x, from += 3) {
      if (x / step_ >= width_) continue;
      float* to = row + static_cast<std::ptrdiff_t>(x / step_) * 3;
      for (int c = 0; c < 3; ++c) to[c] += share * from[c];
    }
  }
}

void LivePage::choose_exposure() {
  const double white = luminances_.percentile(kWhitePercentile);
  if (!(white > 0)) return;
  const auto step = static_cast<int>(std::lround(-kStepsPerStop * std::log2(white)));
  if (step == exposure_step_) return;
  exposure_step_ = step;
  for (int& version : versions_) version += version > 0 ? 1 : 0;
}

void LivePage::tile(const LiveTile& tile) {
  const std::scoped_lock lock(mutex_);
  add(tile);
  luminances_.add(tile.rgb);
  map_lines_ = tile.map_lines;
  n_committed_ = std::max(n_committed_, tile.committed_lines);
  const int first = tile.y_px / step_ / kStripRows;
  const int last = std::min((tile.y_px + tile.height_px - 1) / step_ / kStripRows, n_strips() - 1);
  for (int strip = first; strip <= last; ++strip) ++versions_[static_cast<std::size_t>(strip)];
  if (tile.x_px + tile.width_px < scan_width_) return;
  n_shown_ = tile.y_px + tile.height_px;
  lag_lines_ = tile.committed_lines - n_shown_;
  choose_exposure();
}

void LivePage::set_phase(const std::string& phase) {
  const std::scoped_lock lock(mutex_);
  phase_ = phase;
}

void LivePage::set_lines(int n_committed, int n_lines) {
  const std::scoped_lock lock(mutex_);
  n_committed_ = n_committed;
  n_lines_ = n_lines;
}

void LivePage::finish(const std::filesystem::path& view, const std::filesystem::path& receipt,
                      const std::string& sentence) {
  const std::scoped_lock lock(mutex_);
  phase_ = "done";
  ended_ = true;
  view_ = view;
  receipt_ = receipt;
  sentence_ = sentence;
}

std::string LivePage::state_json() const {
  const std::scoped_lock lock(mutex_);
  const nlohmann::ordered_json state = {{"schema", "reseau-live/1"},
                                        {"phase", phase_},
                                        {"ended", ended_},
                                        {"message", sentence_},
                                        {"lines", n_lines_},
                                        {"lines_committed", n_committed_},
                                        {"lines_shown", n_shown_},
                                        {"lag_lines", lag_lines_},
                                        {"map_lines", map_lines_},
                                        {"step", step_},
                                        {"width_px", width_},
                                        {"height_px", height_},
                                        {"strip_rows", kStripRows},
                                        {"exposure", std::exp2(exposure_step_ / kStepsPerStop)},
                                        {"strips", versions_},
                                        {"view", !view_.empty()},
                                        {"receipt", !receipt_.empty()}};
  return state.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::optional<std::string> LivePage::strip_png(int strip) const {
  std::vector<float> rgb;
  int width = 0, n_rows = 0;
  double exposure = 1;
  {
    const std::scoped_lock lock(mutex_);
    if (strip < 0 || strip >= n_strips()) return std::nullopt;
    width = width_;
    n_rows = std::min(kStripRows, height_ - strip * kStripRows);
    const auto row = static_cast<std::ptrdiff_t>(width_) * 3;
    const auto first = rgb_.begin() + strip * kStripRows * row;
    rgb.assign(first, first + n_rows * row);
    exposure = std::exp2(exposure_step_ / kStepsPerStop);
  }
  std::vector<std::uint8_t> samples(rgb.size());
  static_cast<void>(
      ViewEncoder(srgb_from_picture_, exposure).encode(rgb, std::span<std::uint8_t>(samples)));
  return encode_png(width, n_rows, samples);
}

bool LivePage::ended() const {
  const std::scoped_lock lock(mutex_);
  return ended_;
}

std::filesystem::path LivePage::view() const {
  const std::scoped_lock lock(mutex_);
  return view_;
}

std::filesystem::path LivePage::receipt() const {
  const std::scoped_lock lock(mutex_);
  return receipt_;
}

}  // namespace reseau
