// All parameters of the optics over the frame, from every edge that was measured.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "calibration/profile/records.h"
#include "calibration/psf/psf_fit.h"
#include "capture/cli/calibrate_focus.h"
#include "capture/cli/calibrate_run.h"

namespace reseau::cli {

// `focus`: scans of the best edge of the first file at other settings; none where the files
// themselves are those scans. Nothing where `shared` is no fit, or when it was stopped.
[[nodiscard]] std::optional<PsfFieldRecord> field_of(const std::vector<MeasuredFile>& files,
                                                     const std::vector<FocusShot>& focus,
                                                     const PsfFit& shared,
                                                     const std::function<bool()>& stop);

// Surfaces and MTF50 at 5 x 5 places.
[[nodiscard]] nlohmann::ordered_json psf_field_to_json(const PsfFieldRecord& field);
[[nodiscard]] std::string describe(const PsfFieldRecord& field);
[[nodiscard]] std::string psf_field_html(const PsfFieldRecord& field);

}  // namespace reseau::cli
