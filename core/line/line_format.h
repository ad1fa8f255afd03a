// What one scan delivers: size, channels, resolution. The canonical layout of samples everywhere in
// the program is [line][channel][pixel], uint16_t native endian, padding gone, x un-mirrored, full
// scale 65535 whatever the unit's A/D depth is (a 14-bit value v arrives as round(v * 65535 /
// 16383), which is reversible).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace reseau {

enum class Channel : std::uint8_t { kRed, kGreen, kBlue, kInfrared, kGrey };

struct LineFormat {
  int width_px = 0;
  int n_lines = 0;                // lines that the whole scan will have
  std::vector<Channel> channels;  // in the order of the planes of a line
  int significant_bits = 16;      // of the A/D converter or the file, before scaling to 16 bits
  double x_dpi = 0;               // along the line; 0 = unknown
  double y_dpi = 0;               // along the motion; 0 = unknown

  [[nodiscard]] int n_channels() const { return static_cast<int>(channels.size()); }
  [[nodiscard]] std::size_t samples_per_line() const {
    return static_cast<std::size_t>(width_px) * channels.size();
  }
  // Index of a channel's plane, or -1.
  [[nodiscard]] int plane_of(Channel channel) const {
    for (int i = 0; i < n_channels(); ++i) {
      if (channels[static_cast<std::size_t>(i)] == channel) return i;
    }
    return -1;
  }
  bool operator==(const LineFormat&) const = default;
};

}  // namespace reseau
