// Optics and sensor: from a film to numbers. Each sample is the film's transmittance blurred by a
// Gaussian, integrated over the square aperture of a pixel, multiplied by the exposure, with noise,
// through the A/D converter.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "drivers/sim/film.h"
#include "drivers/sim/optics_spec.h"
#include "drivers/sim/scan_geometry.h"

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
};

// Immutable after construction; thread-safe. Results do not depend on how a window is cut into
// calls, nor on the number of threads.
class ScanRenderer {
 public:
  ScanRenderer(std::shared_ptr<const Film> film, const OpticsSpec& optics, const ScanWindow& window,
               const ScanGeometry& geometry = {});

  [[nodiscard]] const ScanWindow& window() const { return window_; }
  // Transmittances after the optics, without noise: [line][channel R G B IR][pixel].
  void transmittance(int first_line, int n_lines, std::span<float> out) const;

 private:
  struct Kernel {
    int first_cell = 0;  // of weights[0], relative to the first cell of the pixel
    std::vector<float> weights;
  };
  struct RowCache;
  static Kernel make_kernel(double sigma_px, double aperture_px, int cells_per_px);
  void convolve_rows(int first_line, int n_lines, std::span<float> out) const;
  void make_row(std::int64_t cell_row, RowCache& cache) const;

  std::shared_ptr<const Film> film_;
  ScanWindow window_;
  ScanGeometry geometry_;
  int cells_per_px_;
  bool point_rows_;  // so coarse a pitch that a line is a single row of cells
  std::array<Kernel, kChannels> kernels_;
  int reach_px_ = 0;  // of the longest kernel
  // Optical pixels of the window that see film; the others see the opaque holder.
  int active_begin_ = 0, n_active_ = 0;
};

}  // namespace reseau::sim
