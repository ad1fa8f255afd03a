// A small scan whose every sample can be foretold from its place.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/line/capture_context.h"
#include "core/line/line_block.h"
#include "core/line/line_format.h"

namespace reseau::test {

inline LineFormat small_format(int width_px, int n_lines, bool infrared = true) {
  LineFormat format;
  format.width_px = width_px;
  format.n_lines = n_lines;
  format.channels = {Channel::kRed, Channel::kGreen, Channel::kBlue};
  if (infrared) format.channels.push_back(Channel::kInfrared);
  format.x_dpi = format.y_dpi = 4000;
  return format;
}

inline CaptureContext small_context() {
  CaptureContext context;
  context.device_name = "sim:ls5000";
  context.make = "Nikon";
  context.model = "LS-5000 ED";
  context.firmware = "1.02";
  context.serial = "A<1>&\"x\"";
  context.holder = "MA-21";
  context.started_at_utc = "2026-11-22T10:15:00Z";
  context.focus_position = 213;
  context.exposure_us = {812.5, 700.1, 0.1 + 0.2, std::nullopt};
  return context;
}

inline std::uint16_t sample_at(int line, int channel, int x) {
  return static_cast<std::uint16_t>((line * 7919 + channel * 104729 + x * 31 + 1) & 0xFFFF);
}

inline LineBlock block_of(const LineFormat& format, int first_line, int n_lines) {
  LineBlock block;
  block.first_line = first_line;
  block.n_lines = n_lines;
  block.width_px = format.width_px;
  block.n_channels = format.n_channels();
  for (int y = first_line; y < first_line + n_lines; ++y) {
    for (int c = 0; c < format.n_channels(); ++c) {
      for (int x = 0; x < format.width_px; ++x) block.samples.push_back(sample_at(y, c, x));
    }
  }
  return block;
}

// What libtiff finds in the first directory: lines that are right from the top, and how many the
// directory claims. Any error or wrong sample ends the count. claimed = -1: libtiff refused it.
struct TiffCheck {
  int claimed = -1;
  int right = 0;
  int samples = 0;
  std::vector<std::string> complaints;
};
TiffCheck check_tiff(const std::filesystem::path& path, const LineFormat& format);

}  // namespace reseau::test
