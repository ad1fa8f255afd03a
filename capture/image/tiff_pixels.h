#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "capture/image/tiff_file.h"

namespace reseau {

struct TiffPixels {
  // [line][sample][pixel], 16 bit: v * 257 for 8-bit samples, round(65535 v) for float ones,
  // clamped. Only `n_lines` lines.
  std::vector<std::uint16_t> samples;
  int n_lines = 0;              // below the height when the file is cut off or damaged
  std::uint64_t n_clamped = 0;  // float samples that were outside 0..1 or not finite
};

// A sentence why decode_page cannot read this page, or empty: sample type, colour model, layout.
[[nodiscard]] std::string unsupported_reason(const TiffPage& page);

// Decodes the current page from the top until the data end. Allocates no more than the lines that
// the file can hold. Never throws for damaged data.
[[nodiscard]] TiffPixels decode_page(TiffFile& file);

}  // namespace reseau
