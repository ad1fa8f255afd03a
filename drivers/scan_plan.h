// Ask, be told what is possible, then act: a ScanRequest is what a person asked for, a ScanPlan is
// everything derived from it, immutable once negotiated. Plain values, comparable and printable.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/line/line_format.h"

namespace reseau {

// Film area from the corner where the scan starts [mm]. Absent fields mean "all there is".
struct AreaRequest {
  std::optional<double> left_mm;
  std::optional<double> top_mm;
  std::optional<double> width_mm;
  std::optional<double> height_mm;
};

struct FocusRequest {
  enum class Mode { kAuto, kKeep, kPosition };
  Mode mode = Mode::kAuto;
  int position = 0;                  // kPosition: in the unit's own steps
  std::optional<double> x_mm, y_mm;  // kAuto: the point; absent = the middle of the area
};

struct ExposureRequest {
  enum class Mode { kMeter, kFixed };
  Mode mode = Mode::kMeter;
  double factor = 1.0;  // kMeter: multiplies the metered exposures
  // kFixed: red, green, blue, infrared [us]; absent = the unit's own white balance.
  std::array<std::optional<double>, 4> exposure_us;
};

struct ScanRequest {
  std::optional<int> resolution_dpi;  // absent = the unit's optical resolution
  AreaRequest area;
  std::optional<int> depth_bits;  // absent = the deepest
  bool infrared = true;
  FocusRequest focus;
  ExposureRequest exposure;
  int frame = 1;
};

// One field that was granted otherwise than asked.
struct Adjustment {
  std::string field;
  std::string asked;
  std::string granted;
  std::string why;
};

// Window coordinates are pixels of the unit's maximum resolution ("optical px").
struct ScanPlan {
  int resolution_dpi = 0;
  int pitch = 1;  // optical pixels per delivered pixel
  int x_origin_px = 0, y_origin_px = 0, window_width_px = 0, window_height_px = 0;
  // The unit may not crop along the line; then it delivers the whole line and the driver crops.
  int crop_left_px = 0;  // in delivered pixels
  int depth_bits = 16;
  bool infrared = true;
  FocusRequest focus;
  ExposureRequest exposure;
  int frame = 1;
  int focus_x_px = 0, focus_y_px = 0;  // kAuto: optical px
  LineFormat format;                   // what read() will deliver

  // Several lines of text that name every field, for golden tests and logs.
  [[nodiscard]] std::string describe() const;
};

struct Negotiated {
  ScanPlan plan;
  std::vector<Adjustment> adjusted;
};

}  // namespace reseau
