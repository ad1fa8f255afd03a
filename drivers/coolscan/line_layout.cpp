#include "drivers/coolscan/line_layout.h"

#include <algorithm>

namespace reseau::coolscan {

PaddingRecord computed_padding(int width_px, int n_colours, int bits, int max_packet_bytes) {
  LineLayout layout{width_px, n_colours, bits, {}};
  // UNVERIFIED(no USB unit seen without record 6 at odd 8-bit widths): the byte comes first.
  if (bits <= 8 && width_px % 2 != 0) layout.padding.colour_before_bytes = 1;
  const int over = layout.line_bytes() % max_packet_bytes;
  layout.padding.line_after_bytes = over == 0 ? 0 : max_packet_bytes - over;
  return layout.padding;
}

std::uint16_t full_scale_16(std::uint32_t value, int bits) {
  const std::uint32_t full = (1U << bits) - 1;
  return static_cast<std::uint16_t>((std::min(value, full) * 65535U + full / 2) / full);
}

void decode_line(const LineLayout& layout, ByteView line, int crop_left_px, int crop_width_px,
                 std::span<std::uint16_t> out) {
  CHECK(line.size() == static_cast<std::size_t>(layout.line_bytes()));
  CHECK(crop_left_px >= 0 && crop_width_px >= 0 && crop_left_px + crop_width_px <= layout.width_px);
  const auto crop_width = static_cast<std::size_t>(crop_width_px);
  CHECK(out.size() == static_cast<std::size_t>(layout.n_colours) * crop_width);
  const std::size_t sample_bytes = static_cast<std::size_t>(layout.bytes_per_sample());
  // Un-mirrored pixel x is sample width - 1 - x.
  const auto last_sample = static_cast<std::size_t>(layout.width_px - 1 - crop_left_px);
  for (int colour = 0; colour < layout.n_colours; ++colour) {
    const int plane_offset = layout.padding.line_before_bytes + colour * layout.colour_bytes() +
                             layout.padding.colour_before_bytes;
    const std::byte* sample = line.data() + plane_offset + last_sample * sample_bytes;
    std::uint16_t* const plane = out.data() + static_cast<std::size_t>(colour) * crop_width;
    for (std::size_t x = 0; x < crop_width; ++x, sample -= sample_bytes) {
      std::uint32_t value = std::to_integer<std::uint32_t>(sample[0]);
      if (sample_bytes == 2) value = value << 8 | std::to_integer<std::uint32_t>(sample[1]);
      plane[x] =
          layout.bits == 16 ? static_cast<std::uint16_t>(value) : full_scale_16(value, layout.bits);
    }
  }
}

}  // namespace reseau::coolscan
