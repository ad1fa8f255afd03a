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
  kCurves = 0xE3,
  kFrames = 0xC8,
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
  bool whole_lines = false;   // an image READ must be whole lines of all colours
  bool whole_frames = false;  // a thumbnail READ must be whole frames
  int holder_id = 0;          // page with the name of the holder, 0 none
  PitchRule pitch_rule = PitchRule::kAnyInteger;
  bool thumbnails_reversed = false;
  bool has_frame_page = false;
  bool film_addresses = false;  // Y counts along a strip of film
  bool one_frame_per_window = false;
  int optical_dpi = 0, max_dpi = 0, min_dpi = 0;
  int x_origin_max_px = 0, x_origin_min_px = 0;  // equal: X cannot be cropped
  int max_width_px = 0;
  // One after the last pixel that a window may reach.
  [[nodiscard]] int x_end_px() const {
    return x_origin_max_px > x_origin_min_px ? x_origin_max_px + 1 : max_width_px;
  }
  int y_origin_max_px = 0, y_origin_min_px = 0;  // maximum 0: film not known yet
  int max_height_px = 0;
  int thumbnail_dpi = 0;  // 0: no thumbnails
  int frame_capacity = 1, frames_present = 0;
  int focus_min = 0, focus_max = 0;
  int converter_bits = 0;
  int sensor_pixels = 0;
  int line_gap = 0, sensor_lines = 0;  // 0 lines: the page does not say, see sensor_lines()
  std::size_t unread_bytes = 0;        // of the page, after the last known field
};
[[nodiscard]] AddressPage parse_addresses(ByteView page);

// Page D1.
struct WindowPage {
  std::uint8_t kinds = 0, modes = 0, interleavings = 0;  // bits as in the window descriptor
  std::uint8_t depths = 0;                               // b1 8, b2 10, b3 12, b4 14, b5 16 bits
  std::uint32_t exposure_min_10ns = 1, exposure_max_10ns = 0x03FFFFFF;
  std::size_t unread_bytes = 0;

  [[nodiscard]] std::vector<int> depths_bits() const;  // ascending
  [[nodiscard]] bool thumbnails() const { return (kinds & 0x02) != 0; }
  [[nodiscard]] bool multiple_readings() const { return (modes & 0x10) != 0; }
  [[nodiscard]] bool high_speed() const { return (modes & 0x04) != 0; }
  [[nodiscard]] bool multi_line() const { return (interleavings & 0x40) != 0; }
};
[[nodiscard]] WindowPage parse_window_abilities(ByteView page);

// Page E1.
struct DutyPage {
  bool remove_padding = false;
  bool look_up_table = false;  // one must be in place for each colour used
  bool white_balance_exposure = false;
  bool averages_readings = false;  // the host must
  bool frame_table = false;        // data type 8F can be read
  bool set_frame_table = false;    // and sent
  bool frame_rectangles = false;   // data type 88 can be sent
  bool perforations = false;       // data type 8E
  bool ccd_curves = false;         // data type 91, and the host must correct with it
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

// Lines that one pass can use; 1 where there is no multi-line mode.
[[nodiscard]] int sensor_lines(const AddressPage& addresses, const WindowPage& windows);

}  // namespace reseau::coolscan
