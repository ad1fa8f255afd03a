// What distinguishes one simulated PIE unit from another. Sources: SANE's pieusb backend and
// s6stkurz/reflecta-rps-7200, docs/protocol.md; scan areas and sensors of the other models are
// assumptions.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/sim/sim_spec.h"

namespace reseau::sim::pie {

inline constexpr std::uint16_t kGenesysVendor = 0x05e3;

struct PieModel {
  std::string_view name;  // in the device name: "rps7200"
  int number;             // INQUIRY [116-117]
  std::uint16_t product_id;
  std::string_view product;  // 16 characters at most
  int max_dpi;
  int width_px, height_px;  // scan area at max_dpi
  int sensor_px;            // pixels of the sensor: length of its mask and of calibration lines
  int filter_offset;        // rows between the sensor's colours
  bool has_transport, has_strip;
  bool confirms_frame;   // sub-command 17 before "skip shading"
  bool own_calibration;  // calibrates in a pass of its own only (quality 0800)
  bool reports_film;     // READ STATE [8]
  bool fragile;  // hangs after SCAN 0, a READ of 64 lines, more than 32 KiB per announcement
  double infrared_blue;                   // how much brighter blue is in a pass with infrared
  std::array<std::uint16_t, 4> exposure;  // reference, red green blue infrared
  std::array<std::uint8_t, 4> gain;
};

// nullptr for a name that is none of these.
[[nodiscard]] const PieModel* find_pie_model(std::string_view name);
[[nodiscard]] std::vector<std::string> pie_model_names();

// Film, optics and sensor as this unit has them, before the settings of a name change them.
void set_pie_defaults(const PieModel& model, SimSpec& spec);

}  // namespace reseau::sim::pie
