// The provisional picture of a running scan: for the local page, and as events.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include <CLI/App.hpp>

#include "capture/cli/reporter.h"
#include "capture/page/live_page.h"
#include "capture/page/page_server.h"

namespace reseau::cli {

struct PageChoice {
  bool wanted = false;
  std::string listen;  // HOST:PORT; empty: a free port of this machine alone
  bool stay = false;   // until Ctrl-C, when the scan is over

  void add_flag_to(CLI::App& app);
  void add_listen_to(CLI::App& app);
  [[nodiscard]] bool any() const { return wanted || stay || !listen.empty(); }
};

// Serves the page from its making to its end. Thread-safe where LivePage is.
class ScanPage final : public LiveTileSink {
 public:
  // Says where the page is. Throws InputError where the address cannot be had.
  ScanPage(const PageChoice& choice, const std::array<double, 9>& srgb_from_picture,
           Reporter& reporter);

  void begin(int width_px, int height_px) override;
  // Events say when a row of tiles is whole.
  void tile(const LiveTile& tile) override;
  void set_phase(const std::string& phase) { page_.set_phase(phase); }
  void set_lines(int n_committed, int n_lines) { page_.set_lines(n_committed, n_lines); }
  // Shows the end, and returns when a browser that looks has it, after some seconds, or, where the
  // page is to stay, when stop is requested.
  void finish(const std::filesystem::path& view, const std::filesystem::path& receipt,
              const std::string& sentence, const std::stop_token& stop);

 private:
  const bool stay_;
  Reporter& reporter_;
  LivePage page_;
  std::optional<PageServer> server_;
  int width_px_ = 0;
};

}  // namespace reseau::cli
