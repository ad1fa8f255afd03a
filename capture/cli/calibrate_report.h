// The result of a calibration as one HTML file that needs nothing else.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calibration/gate/gate.h"
#include "calibration/psf/psf_fit.h"
#include "capture/cli/calibrate_focus.h"
#include "capture/cli/calibrate_gate.h"
#include "capture/cli/calibrate_psf.h"
#include "capture/cli/calibrate_random.h"
#include "capture/cli/calibrate_run.h"

namespace reseau::cli {

struct CalibrationReport {
  const std::vector<MeasuredFile>& files;
  const PsfFit* psf = nullptr;                        // null: not fitted
  const PsfChoice* psf_edges = nullptr;               // what it was made of
  const Profile* profile = nullptr;                   // null: nothing that belongs to one unit
  const FocusResult* focus = nullptr;                 // null: fewer than three settings
  const GateResult* gate = nullptr;                   // null: no scans of an open frame
  const std::vector<RandomOfFile>* random = nullptr;  // null: no random target
  const std::vector<RandomAgainstEdge>* random_pairs = nullptr;  // with `random`
  std::string made_at_utc;
};

// Tables and plots (edge spread, line spread, modulation transfer with its 95 % band, what the
// physical model leaves over) of every edge; figures under the names of ISO 12233 and FADGI,
// without claiming conformance. Same input, same text.
[[nodiscard]] std::string calibration_html(const CalibrationReport& report);

}  // namespace reseau::cli
