// A few consecutive lines on their way from a scanner to a sink. The owner keeps the buffer and
// refills it, so that no block allocates after the first.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/check.h"
#include "core/line/line_format.h"

namespace reseau {

struct LineBlock {
  int first_line = 0;  // absolute and contiguous: a gap is a DeviceError of the driver
  int n_lines = 0;
  int width_px = 0;
  int n_channels = 0;
  std::vector<std::uint16_t> samples;  // [line][channel][pixel]; may be larger than used

  [[nodiscard]] std::span<const std::uint16_t> plane(int line_in_block, int channel) const {
    DCHECK(line_in_block >= 0 && line_in_block < n_lines && channel >= 0 && channel < n_channels);
    const auto width = static_cast<std::size_t>(width_px);
    const auto index =
        static_cast<std::size_t>(line_in_block) * static_cast<std::size_t>(n_channels) +
        static_cast<std::size_t>(channel);
    return {samples.data() + index * width, width};
  }
  // All lines as one run.
  [[nodiscard]] std::span<const std::uint16_t> used() const {
    return {samples.data(), static_cast<std::size_t>(n_lines) *
                                static_cast<std::size_t>(n_channels) *
                                static_cast<std::size_t>(width_px)};
  }
};

}  // namespace reseau
