// The result of a calibration as one HTML file that needs nothing else.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calibration/psf/psf_fit.h"
#include "capture/cli/calibrate_run.h"

namespace reseau::cli {

struct CalibrationReport {
  const std::vector<MeasuredFile>& files;
  const PsfFit* psf = nullptr;       // null: not fitted
  const Profile* profile = nullptr;  // null: nothing that belongs to one unit
  std::string made_at_utc;
};

// Tables and plots (edge spread, line spread, modulation transfer with its 95 % band, what the
// physical model leaves over) of every edge; figures under the names of ISO 12233 and FADGI,
// without claiming conformance. Same input, same text.
[[nodiscard]] std::string calibration_html(const CalibrationReport& report);

}  // namespace reseau::cli
