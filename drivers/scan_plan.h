// Ask, be told what is possible, then act: a ScanRequest is what a person asked for, a ScanPlan is
// everything derived from it, immutable once negotiated. Plain values, comparable and printable.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/line/line_format.h"

namespace reseau {

inline constexpr double kMmPerInch = 25.4;

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
  // kMeter: red, green and blue keep the ratios of the unit's own white balance. Otherwise each
  // channel is metered by itself, as for colour negatives. Infrared always is.
  bool lock = true;
  // kFixed: red, green, blue, infrared [us]; absent = the unit's own white balance.
  std::array<std::optional<double>, 4> exposure_us;
};

// Which lines of a sensor that has several take part.
enum class SensorLines {
  kAuto,  // as is known to be right on real units
  kOne,   // one: slower, no difference between neighbouring lines ("super fine")
  kAll
};

struct ScanRequest {
  std::optional<int> resolution_dpi;  // absent = the unit's optical resolution
  AreaRequest area;
  std::optional<int> depth_bits;  // absent = the deepest
  bool infrared = true;
  FocusRequest focus;
  ExposureRequest exposure;
  int frame = 1;
  double frame_offset_mm = 0;  // moves this frame along the film, against where the unit has it
  int samples = 1;             // readings of each line, averaged
  SensorLines sensor_lines = SensorLines::kAuto;
  // A quick, coarse picture of the whole strip, or of the whole holder, without infrared. Area and
  // frame are not looked at; the unit then knows where the frames are.
  bool overview = false;
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
  int crop_left_px = 0;    // in delivered pixels
  int crop_top_lines = 0;  // likewise lines at the head of the window that are not delivered
  int depth_bits = 16;
  bool infrared = true;
  FocusRequest focus;
  ExposureRequest exposure;
  int frame = 1;
  int focus_x_px = 0, focus_y_px = 0;  // kAuto: optical px
  LineFormat format;                   // what read() will deliver
  int frame_offset_px = 0;             // of the frame, along the film; in y_origin_px already
  int samples = 1;                     // readings per line
  int sensor_lines = 1;                // lines of the sensor that take part
  bool overview = false;

  // Several lines of text that name every field, for golden tests and logs.
  [[nodiscard]] std::string describe() const;
};

struct Negotiated {
  ScanPlan plan;
  std::vector<Adjustment> adjusted;
};

}  // namespace reseau
