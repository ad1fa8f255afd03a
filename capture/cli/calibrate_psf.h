// The optics of the unit from all edges that were measured, for people and as JSON.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "calibration/psf/psf_fit.h"
#include "capture/cli/calibrate_run.h"

namespace reseau::cli {

// Whether fit_psf can use it: figures, in a channel that a scanner has; grey counts as green.
[[nodiscard]] bool fits_psf(const ChannelEdge& edge);
// All that it can use, file by file, edge by edge. The focus is that of the file, where it says so.
[[nodiscard]] std::vector<PsfEdge> psf_edges(const std::vector<MeasuredFile>& files);

[[nodiscard]] nlohmann::ordered_json psf_to_json(const PsfFit& fit);
[[nodiscard]] std::string describe(const PsfFit& fit);

}  // namespace reseau::cli
