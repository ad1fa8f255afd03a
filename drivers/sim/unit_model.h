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

struct UnitModel {
  std::string_view name;      // in the device name: "ls5000"
  std::string_view product;   // 16 characters at most
  std::string_view revision;  // 4 characters
  std::uint16_t product_id;
  std::uint16_t bcd_device;
  int adc_bits;
  std::vector<int> depths_bits;    // what a window may ask for
  int descriptor_bytes;            // of GET WINDOW
  int descriptor_list_bytes;       // longest SET WINDOW list (page C1 [5-6])
  std::uint32_t window_reply_tag;  // GET WINDOW [2-3]
  bool any_pitch;                  // every integer pitch; otherwise 1 and even ones
  std::uint8_t scan_modes;         // window byte 43, page D1 [5]
  std::uint8_t interleavings;      // window byte 44, page D1 [6]
  bool multi_reading;
  bool has_lut;
  bool has_ccd_curves;
  Exposures default_exposure;         // of the windows at power on
  Exposures white_balance_exposure;   // data type 8C
  std::string_view page_d1, page_e1;  // hex, whole
};

inline constexpr int kOpticalDpi = 4000;
inline constexpr int kSensorPx = 3946;
inline constexpr int kFrameHeightPx = 5959;  // also the pitch of frames on a strip
inline constexpr int kThumbnailPitch = 41;
inline constexpr int kThumbnailDpi = 97;
// The film advances by six pulses of seven address units per thumbnail line.
inline constexpr int kThumbnailStepPx = 42;
inline constexpr int kPacketBytes = 512;
inline constexpr int kFocusMax = 0x143;
inline constexpr std::uint32_t kExposureMax = 0x03ffffff;

// Throws InputError for a model that does not exist, listing those that do.
[[nodiscard]] const UnitModel& unit_model(std::string_view name);
[[nodiscard]] std::vector<std::string> unit_model_names();

}  // namespace reseau::sim
