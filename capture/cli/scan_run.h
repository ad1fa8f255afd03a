// What `scan` and `replay` do.
#pragma once

#include <filesystem>
#include <string>

#include "capture/cli/develop_choice.h"
#include "capture/cli/program.h"
#include "capture/cli/scan_choice.h"
#include "capture/cli/scan_page.h"

namespace reseau::cli {

struct ScanJob {
  ScanChoice scan;
  PlaceChoice place;
  DevelopChoice picture;
  PageChoice page;
  std::filesystem::path record;  // empty = none
  bool dont_scan = false;
  bool load = false, eject = false;  // before and after
  bool no_reconstruct = false;
  // Of replays (drivers/registry.h).
  double replay_speed = 0;
  std::string replay_fault;
};

// Of `scan` and `serve`, but for --page.
void add_scan_options(CLI::App& app, ScanJob& job);

// Says what it will do, scans, reconstructs, writes the receipt, prints the path of the picture (of
// the master where there is none). Throws Failure and whatever describe() understands.
[[nodiscard]] ExitCode run_scan(const ScanJob& job, Work& work);

}  // namespace reseau::cli
