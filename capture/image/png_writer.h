#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "capture/store/part_file.h"

namespace reseau {

// Writes an 8-bit RGB PNG, tagged as sRGB, row by row. Same input, same bytes. Thread-bound.
class PngWriter {
 public:
  // `file` must outlive the writer; publishing it is left to the caller. `dpi` 0 = unknown. Throws
  // std::system_error, as the other functions do.
  PngWriter(const PartFile& file, int width_px, int height_px, double dpi);
  ~PngWriter();
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;

  void row(std::span<const std::uint8_t> rgb);
  // After the last row.
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace reseau
