// What a unit says about itself in its INQUIRY pages. Pages are walked, not indexed: some fields
// have an extension bit that moves all later ones, and a page that ends early means the default for
// what is missing. Nothing is read past the length that the page itself states; transports may pad.
// Source: LS-5000 interface specification, INQUIRY; recorded Nikon Scan session; pages of LS-40,
// LS-50 and LS-8000 units.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "drivers/bytes.h"

namespace reseau::coolscan {

enum PageCode : std::uint8_t {
  kPageList = 0x00,
  kAdapterName = 0x01,
  kAddresses = 0xC1,
  kWindowAbilities = 0xD1,
  kDuties = 0xE1,
};

struct StandardInquiry {
  std::string vendor, product, revision;  // without trailing spaces
};
// At least kInquiryBytes.
[[nodiscard]] StandardInquiry parse_standard_inquiry(ByteView data);

[[nodiscard]] std::vector<std::uint8_t> parse_page_list(ByteView page);
[[nodiscard]] std::string parse_name_page(ByteView page);

enum class PitchRule : std::uint8_t { kContinuous, kAnyInteger, kDivisorsOfLineGap, kOneOrEven };

// Page C1. All addresses and sizes in optical pixels.
struct AddressPage {
  PitchRule pitch_rule = PitchRule::kAnyInteger;
  bool one_frame_per_window = false;
  int optical_dpi = 0, max_dpi = 0, min_dpi = 0;
  int x_origin_max_px = 0, x_origin_min_px = 0;  // equal: X cannot be cropped
  int max_width_px = 0;
  int y_origin_max_px = 0, y_origin_min_px = 0;  // maximum 0: film not known yet
  int max_height_px = 0;
  int frame_capacity = 1, frames_present = 0;
  int focus_min = 0, focus_max = 0;
  int converter_bits = 0;
  int sensor_pixels = 0;
  int line_gap = 0, sensor_lines = 1;
  std::size_t unread_bytes = 0;  // of the page, after the last known field
};
[[nodiscard]] AddressPage parse_addresses(ByteView page);

// Page D1.
struct WindowPage {
  std::uint8_t kinds = 0, modes = 0, interleavings = 0;  // bits as in the window descriptor
  std::uint8_t depths = 0;                               // b1 8, b2 10, b3 12, b4 14, b5 16 bits
  std::uint32_t exposure_min_10ns = 1, exposure_max_10ns = 0x03FFFFFF;
  std::size_t unread_bytes = 0;

  [[nodiscard]] std::vector<int> depths_bits() const;  // ascending
};
[[nodiscard]] WindowPage parse_window_abilities(ByteView page);

// Page E1.
struct DutyPage {
  bool remove_padding = false;
  bool look_up_table = false;  // one must be in place for each colour used
  bool white_balance_exposure = false;
  bool frame_table = false;  // data type 8F can be read
  int table_in_bits = 0, table_out_bits = 0;
  // Groups 8x to Fx: bit n of group g says that operation 16 * (8 + g) + n exists.
  std::array<std::uint8_t, 8> operations{};
  std::size_t unread_bytes = 0;

  [[nodiscard]] bool offers(std::uint8_t operation) const {
    return operation >= 0x80 &&
           (operations[static_cast<std::size_t>((operation >> 4) - 8)] >> (operation & 0x0F) & 1) !=
               0;
  }
};
[[nodiscard]] DutyPage parse_duties(ByteView page);

// Data type 8F: Y addresses of the frames of a strip [optical px]. `data` with its 6-byte head.
[[nodiscard]] std::vector<int> parse_frame_table(ByteView data);

}  // namespace reseau::coolscan
