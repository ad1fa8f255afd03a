// What `calibrate` was given, and all that is read from it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calibration/gate/gate.h"
#include "calibration/profile/profile.h"
#include "capture/cli/calibrate_bench.h"
#include "capture/cli/calibrate_focus.h"
#include "capture/cli/calibrate_random.h"
#include "capture/cli/calibrate_reseau.h"
#include "capture/cli/calibrate_run.h"
#include "capture/cli/program.h"
#include "core/line/capture_context.h"

namespace reseau::cli {

struct CalibrateArguments {
  std::vector<std::string> files, gate, random, reseau;
  std::string target = "1,3.2";
  BenchChoice bench;
  std::string roi, infrared_file, profile, model, serial, report;
  std::optional<double> gamma;
  double window_px = 28, dpi = 0;
  bool save = false, compare = false, psf = false;
};

// Everything that was measured, wherever the scans come from.
struct Gathered {
  std::vector<MeasuredFile> files;
  std::vector<FocusShot> focus;
  std::vector<GateScan> gate;
  std::vector<RandomOfFile> random;
  std::vector<ReseauOfFile> reseau;
  CaptureContext gate_context;  // of the first file of an open frame
  double gate_dpi = 0;
};

// False when it was stopped. Failures name the file.
[[nodiscard]] bool gather_files(const CalibrateArguments& options, const MeasureChoice& choice,
                                Work& work, Gathered& out);

// What everything says of the unit; nothing where nothing was measured.
[[nodiscard]] std::optional<Profile> profile_from(const Gathered& all, bool any_edge, bool gate,
                                                  const CalibrateArguments& options);

}  // namespace reseau::cli
