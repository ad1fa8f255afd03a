#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/bytes.h"
#include "drivers/coolscan/records.h"

namespace reseau::coolscan {

// How image data lies on the wire. A record is what one position of the stage gives: one film line,
// or sensor_lines of them at once.
//
//   record  = per reading [line_before, colours, line_after]
//   colour  = [colour_before, width_px x sensor_lines samples, colour_after]
//
// The first reading has all colours, in the order red, green, blue, infrared whatever the SCAN list
// was; later readings leave infrared out. The samples of one pixel from all sensor lines follow
// each other. Samples of more than 8 bits are 16-bit big-endian, right aligned. The sensor is read
// out mirrored. gap records make a block: record p, sensor line l is film line l * gap + p of it.
// A padding record counts bytes per film line; a record has sensor_lines times as many.
// Source: LS-5000 interface specification, image data; recorded Nikon Scan session; for three lines
// reports of users of an LS-9000. UNVERIFIED(which line of an LS-5000 is the earlier one): the
// first.
struct RecordLayout {
  int width_px = 0;
  int n_colours = 0;  // 4: with infrared
  int bits = 16;
  int sensor_lines = 1;
  int gap = 1;  // film lines from one sensor line to the next
  int readings = 1;
  PaddingRecord padding;

  [[nodiscard]] int bytes_per_sample() const { return bits > 8 ? 2 : 1; }
  [[nodiscard]] int colours_of(int reading) const {
    return reading > 0 && n_colours > 3 ? 3 : n_colours;
  }
  [[nodiscard]] int colour_bytes() const {
    return padding.colour_before_bytes + width_px * sensor_lines * bytes_per_sample() +
           padding.colour_after_bytes;
  }
  [[nodiscard]] int bytes_before() const { return padding.line_before_bytes * sensor_lines; }
  [[nodiscard]] int bytes_after(int reading) const;
  [[nodiscard]] std::size_t reading_bytes(int reading) const {
    return static_cast<std::size_t>(bytes_before()) +
           static_cast<std::size_t>(colours_of(reading)) *
               static_cast<std::size_t>(colour_bytes()) +
           static_cast<std::size_t>(bytes_after(reading));
  }
  [[nodiscard]] std::size_t record_bytes() const;
  [[nodiscard]] int lines_per_block() const { return sensor_lines * gap; }
  [[nodiscard]] std::size_t block_bytes() const {
    return record_bytes() * static_cast<std::size_t>(gap);
  }
};

// The padding of a unit that raises no record 6: readings fill whole USB packets, and colours of
// odd 8-bit width are made even where `even_colours`. packet_bytes 0: a link without packets.
[[nodiscard]] PaddingRecord computed_padding(const RecordLayout& layout, int packet_bytes,
                                             bool even_colours = true);

// round(value * 65535 / full scale); a value above full scale counts as full scale.
[[nodiscard]] std::uint16_t full_scale_16(std::uint32_t value, int bits);

// Tables from a 16-bit sample of a sensor line to what the first line would have read:
// [colour][sensor line]; an empty one changes nothing.
using LineTables = std::vector<std::vector<std::vector<std::uint16_t>>>;

// Blocks from the wire to film lines. Immutable, reentrant.
class BlockDecoder {
 public:
  // Delivers crop_width_px pixels from crop_left_px on of the un-mirrored line.
  BlockDecoder(const RecordLayout& layout, int crop_left_px, int crop_width_px,
               const LineTables& corrections = {});

  [[nodiscard]] const RecordLayout& layout() const { return layout_; }
  [[nodiscard]] std::size_t block_samples() const {
    return static_cast<std::size_t>(layout_.lines_per_block() * layout_.n_colours) *
           static_cast<std::size_t>(crop_width_px_);
  }
  // block: layout.block_bytes(). out: layout.lines_per_block() lines of [colour][pixel], scaled to
  // 16 bits, each sensor line corrected, readings averaged (halves round up).
  void decode(ByteView block, std::span<std::uint16_t> out) const;

 private:
  void decode_plane(const std::byte* record, int colour, int sensor_line,
                    std::span<std::uint16_t> out) const;

  RecordLayout layout_;
  int crop_left_px_, crop_width_px_;
  LineTables tables_;  // from the wire's value; empty: the value itself
};

}  // namespace reseau::coolscan
