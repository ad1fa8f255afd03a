#include "capture/cli/scan_page.h"

#include <chrono>
#include <condition_variable>
#include <mutex>

#include <nlohmann/json.hpp>

namespace reseau::cli {

namespace {

// A browser asks three times a second.
constexpr std::chrono::seconds kMostLinger{3};
constexpr std::chrono::milliseconds kLook{50};

}  // namespace

void PageChoice::add_flag_to(CLI::App& app) {
  app.add_flag(
         "--page", wanted,
         "Show the picture on a local page while it is scanned, a moment behind the scan head")
      ->group("Page");
}

void PageChoice::add_listen_to(CLI::App& app) {
  app.add_option("--listen", listen,
                 "The page is at this HOST:PORT; default a free port of 127.0.0.1, which only this "
                 "machine sees")
      ->group("Page");
}

ScanPage::ScanPage(const PageChoice& choice, const std::array<double, 9>& srgb_from_picture,
                   Reporter& reporter)
    : stay_(choice.stay), reporter_(reporter), page_(srgb_from_picture) {
  server_.emplace(choice.listen.empty() ? PageAddress{} : parse_page_address(choice.listen), page_);
  reporter.say("Page      " + server_->url());
  reporter.event("page", {{"url", server_->url()}});
}

void ScanPage::begin(int width_px, int height_px) {
  width_px_ = width_px;
  page_.begin(width_px, height_px);
}

void ScanPage::tile(const LiveTile& tile) {
  page_.tile(tile);
  if (tile.x_px + tile.width_px < width_px_) return;
  const int shown = tile.y_px + tile.height_px;
  reporter_.event("live", {{"rows_shown", shown},
                           {"rows_committed", tile.committed_lines},
                           {"lag_rows", tile.committed_lines - shown},
                           {"map_rows", tile.map_lines}});
}

void ScanPage::finish(const std::filesystem::path& view, const std::filesystem::path& receipt,
                      const std::string& sentence, const std::stop_token& stop) {
  page_.finish(view, receipt, sentence);
  if (stop.stop_requested()) return;
  if (stay_) reporter_.say("The page stays until Ctrl-C: " + server_->url());
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  const auto until = std::chrono::steady_clock::now() + kMostLinger;
  while (!stop.stop_requested() &&
         (stay_ || (server_->owes_the_end() && std::chrono::steady_clock::now() < until))) {
    never.wait_for(lock, stop, kLook, [] { return false; });
  }
}

}  // namespace reseau::cli
