#pragma once

#include <span>

namespace reseau {

// Takes a reconstructed picture row by row, top to bottom. Calls come from one thread in the order
// begin, rows*, end. Layout [row][pixel][3 channels], float, scene-linear. The span is lent until
// rows() returns.
class RgbRowSink {
 public:
  virtual ~RgbRowSink() = default;
  virtual void begin(int width_px, int height_px) = 0;
  virtual void rows(int first_row, int n_rows, std::span<const float> rgb) = 0;
  virtual void end() = 0;
};

}  // namespace reseau
