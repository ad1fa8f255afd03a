// From a film to transmittances, line by line. The seam between the plain optics and the full ones.
#pragma once

#include <span>

namespace reseau::sim {

// What part of the film a pass delivers. At a pitch above 1 the scanner averages that many pixels
// along the sensor and steps as many lines along the motion: sample (i, l) is centred on the
// optical pixel x_px + i * pitch + (pitch - 1) / 2, and the same along y.
struct ScanWindow {
  int x_px = 0, y_px = 0;  // optical pixels
  int width_px = 0;        // delivered pixels
  int n_lines = 0;         // delivered lines
  int pitch = 1;
  int line_step = 0;  // optical lines from line to line when it is not the pitch; 0 = the pitch

  [[nodiscard]] int step() const { return line_step > 0 ? line_step : pitch; }
  // Optical place of a delivered one.
  [[nodiscard]] double optical_x(double x) const { return x_px + x * pitch + (pitch - 1) / 2.0; }
  [[nodiscard]] double optical_y(double y) const { return y_px + y * step() + (pitch - 1) / 2.0; }
};

// Immutable after construction; thread-safe. Results do not depend on how a window is cut into
// calls, nor on the number of threads.
class LineRenderer {
 public:
  virtual ~LineRenderer() = default;
  // Transmittances after the optics, without noise: [line][channel R G B IR][pixel]. first_line and
  // n_lines lie within the window.
  virtual void transmittance(int first_line, int n_lines, std::span<float> out) const = 0;
};

}  // namespace reseau::sim
