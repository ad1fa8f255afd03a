// Calibration with a scanner: a person is told what to lay in, the program scans and measures.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <CLI/App.hpp>

#include "calibration/gate/gate.h"
#include "capture/cli/calibrate_focus.h"
#include "capture/cli/calibrate_run.h"
#include "capture/cli/program.h"
#include "capture/cli/scan_choice.h"

namespace reseau::cli {

struct BenchChoice {
  ScanChoice scan;
  std::string output = ".";  // folder for the scan of the edges and the report
  bool yes = false;          // nobody answers: everything is in place, or the unit is simulated
  bool skip_focus = false, skip_gate = false, with_random = false;
  int focus_positions = 9, focus_step = 10;

  void add_to(CLI::App& app);
};

struct BenchWork {
  std::string device;
  std::filesystem::path edge_file;
  MeasuredFile edges;
  std::vector<FocusShot> focus;
  std::vector<GateScan> gate;
  std::filesystem::path random_file;  // empty without --with-random
};

// The edge target, its focus, the random target where it is asked for, the open frame, one after
// the other. Nothing when it was stopped. Throws Failure, and what scanners and files throw.
[[nodiscard]] std::optional<BenchWork> run_bench(const BenchChoice& choice,
                                                 const MeasureChoice& measure, Work& work);

}  // namespace reseau::cli
