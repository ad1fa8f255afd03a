// Where lines come from: enough to name the unit in a file, to find its calibration and to repeat
// the scan. Plain data; unknown strings are empty, unknown numbers absent.
#pragma once

#include <array>
#include <optional>
#include <string>

namespace reseau {

struct CaptureContext {
  std::string device_name;  // as in `-d`: "sim:ls5000", "usb:04b0:4002"
  std::string make;
  std::string model;  // "LS-5000 ED"
  std::string firmware;
  std::string serial;
  std::string holder;          // adapter name of the unit
  std::string started_at_utc;  // ISO 8601, "2026-11-22T10:15:00Z"
  std::optional<int> focus_position;
  // Exposure per channel in the order red, green, blue, infrared [us]; absent when not captured.
  std::array<std::optional<double>, 4> exposure_us;
};

}  // namespace reseau
