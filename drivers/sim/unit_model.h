// What distinguishes one simulated model from another: constants and whole pages. Source: LS-5000
// interface specification, inquiry pages; recorded Nikon Scan session (LS-5000, firmware 1.03);
// LS-50 firmware 1.02.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/sim/sim_spec.h"
#include "drivers/sim/wire_bytes.h"

namespace reseau::sim {

// Exposures in units of 10 ns, in the order red, green, blue, infrared.
using Exposures = std::array<std::uint32_t, 4>;

enum class LinkKind { kUsbFullSpeed, kUsbHighSpeed, kScsi };
enum class PitchRule { kAny, kOneOrEven, kDivisorsOfGap };

struct UnitModel {
  std::string_view name;      // in the device name: "ls5000"
  std::string_view product;   // 16 characters at most
  std::string_view revision;  // 4 characters
  LinkKind link = LinkKind::kUsbHighSpeed;
  std::uint16_t product_id = 0;
  std::uint16_t bcd_device = 0;
  int adc_bits = 16;
  std::vector<int> depths_bits{};      // what a window may ask for
  int descriptor_bytes = 50;           // of GET WINDOW
  int descriptor_list_bytes = 58;      // longest SET WINDOW list (page C1 [5-6])
  std::uint32_t window_reply_tag = 0;  // GET WINDOW [2-3]
  PitchRule pitch_rule = PitchRule::kAny;
  std::uint8_t scan_modes = 0x46;     // window byte 43, page D1 [5]
  std::uint8_t interleavings = 0x02;  // window byte 44, page D1 [6]
  bool multi_reading = false;
  bool has_lut = false;
  bool has_ccd_curves = false;
  Exposures default_exposure{};           // of the windows at power on
  Exposures white_balance_exposure{};     // data type 8C
  std::string_view page_c1{};             // hex, whole; the adapter changes a few fields
  std::string_view page_d1{}, page_e1{};  // empty: the model has no such page
  std::string_view page_list{};           // hex; "AA" stands for the adapter's own page
  int optical_dpi = 4000;
  int sensor_px = 3946;
  int frame_height_px = 5959;  // also the pitch of frames on a strip
  int mount_height_px = 5782;
  int min_dpi = 90;
  int thumbnail_dpi = 97;
  int thumbnail_step_px = 42;  // the film advances by six pulses per thumbnail line
  int pulse_px = 7;
  int focus_max = 0x143;
  int sensor_lines = 1, line_gap = 1;
  bool all_windows_only = false;  // GET WINDOW
  bool stage_can_jam = false;     // a window past the boundary is accepted and drives into the stop
  bool loses_busy_commands = false;   // "busy" as a phase means that the command is lost
  bool hates_status_request = false;  // stops answering after a byte 06
  bool line_per_transfer = false;
  bool even_planes = true;   // a filling byte where a plane has an odd number of bytes
  bool has_adapters = true;  // strip, roll, mount …; otherwise holders

  [[nodiscard]] int packet_bytes() const {
    return link == LinkKind::kScsi ? 0 : link == LinkKind::kUsbHighSpeed ? 512 : 64;
  }
  [[nodiscard]] int thumbnail_pitch() const { return optical_dpi / thumbnail_dpi; }
};

inline constexpr std::uint32_t kExposureMax = 0x03ffffff;

// Throws InputError for a model that does not exist, listing those that do.
[[nodiscard]] const UnitModel& unit_model(std::string_view name);
[[nodiscard]] const UnitModel* find_unit_model(std::string_view name);
[[nodiscard]] std::vector<std::string> unit_model_names();

}  // namespace reseau::sim
