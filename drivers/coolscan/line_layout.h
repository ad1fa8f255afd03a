#pragma once

#include <cstdint>
#include <span>

#include "drivers/bytes.h"
#include "drivers/coolscan/records.h"

namespace reseau::coolscan {

// How one line of a one-line pass lies on the wire:
//   line_before, then per colour [colour_before, width_px samples, colour_after], line_after.
// Colours come in the order red, green, blue, infrared whatever the SCAN list was. Samples of more
// than 8 bits are 16-bit big-endian, right aligned. The sensor is read out mirrored.
// Source: LS-5000 interface specification, image data; recorded Nikon Scan session.
struct LineLayout {
  int width_px = 0;
  int n_colours = 0;
  int bits = 16;
  PaddingRecord padding;

  [[nodiscard]] int bytes_per_sample() const { return bits > 8 ? 2 : 1; }
  [[nodiscard]] int colour_bytes() const {
    return padding.colour_before_bytes + width_px * bytes_per_sample() + padding.colour_after_bytes;
  }
  [[nodiscard]] int line_bytes() const {
    return padding.line_before_bytes + n_colours * colour_bytes() + padding.line_after_bytes;
  }
};

// The padding of a unit that raises no record 6: lines fill whole USB packets, and colours of odd
// 8-bit width are made even.
[[nodiscard]] PaddingRecord computed_padding(int width_px, int n_colours, int bits,
                                             int max_packet_bytes);

// One line from the wire: out gets [colour][pixel], crop_width_px pixels per colour from
// crop_left_px on of the un-mirrored line, scaled to 16 bits. line.size() is layout.line_bytes().
void decode_line(const LineLayout& layout, ByteView line, int crop_left_px, int crop_width_px,
                 std::span<std::uint16_t> out);

// round(value * 65535 / full scale); a value above full scale counts as full scale.
[[nodiscard]] std::uint16_t full_scale_16(std::uint32_t value, int bits);

}  // namespace reseau::coolscan
