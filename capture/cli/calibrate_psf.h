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
// As fit_psf takes it, of an edge that fits.
[[nodiscard]] PsfEdge psf_edge(const ChannelEdge& edge, const MeasuredFile& file);
// What fit_psf is given, and the measurement that each was made of.
struct PsfChoice {
  std::vector<PsfEdge> edges;
  std::vector<const ChannelEdge*> of;
};
// The best edges of each file in two directions: as many as tell the optics, at least one of a
// file. The focus is that of the file, where it says so. Refers to `files`.
[[nodiscard]] PsfChoice psf_edges(const std::vector<MeasuredFile>& files);

// Parameters, covariance and fit into the profile, with the surface over the frame that the edges
// of `files` give where there are edges in more places than one. `choice`: what `fit` was made of,
// first of all.
void put_psf(const PsfFit& fit, const PsfChoice& choice, const std::vector<MeasuredFile>& files,
             Profile& profile);
// The surfaces of a profile, at the middle and the corners.
[[nodiscard]] nlohmann::ordered_json field_to_json(const PsfRecord& record);
[[nodiscard]] std::string field_html(const PsfRecord& record);
[[nodiscard]] nlohmann::ordered_json psf_to_json(const PsfFit& fit);
[[nodiscard]] std::string describe(const PsfFit& fit);

}  // namespace reseau::cli
