// Best focus and depth of field of each channel from one edge at several settings.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "calibration/focus/focus_curve.h"
#include "calibration/psf/psf_fit.h"
#include "capture/cli/calibrate_run.h"

namespace reseau::cli {

// The edge at one setting of the unit.
struct FocusShot {
  int position = 0;
  MeasuredEdge edge;
};

struct FocusOfChannel {
  std::string name;
  std::vector<FocusPoint> points;
  FocusFit fit;
  std::optional<Measured> from_green;  // best focus, in steps
};

struct FocusResult {
  double f_cy_per_px = 0;  // of the modulation that is followed
  std::vector<FocusOfChannel> channels;
};

// From files with different focus positions: the edge of each that lies nearest to the best one of
// the first. Empty when fewer than three settings are there.
[[nodiscard]] std::vector<FocusShot> focus_shots(const std::vector<MeasuredFile>& files);

// Nothing when no shot shows an edge.
[[nodiscard]] std::optional<FocusResult> find_focus(const std::vector<FocusShot>& shots);

// For fit_psf, which shares the optics over all settings.
void add_psf_edges(const std::vector<FocusShot>& shots, std::vector<PsfEdge>& to);

void put_focus(const FocusResult& focus, Profile& profile);
[[nodiscard]] nlohmann::ordered_json focus_to_json(const FocusResult& focus);
[[nodiscard]] std::string describe(const FocusResult& focus);
// Table and curve, for the report.
[[nodiscard]] std::string focus_html(const FocusResult& focus);

}  // namespace reseau::cli
