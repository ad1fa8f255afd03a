// The plain optics: a Gaussian and a square aperture, the same everywhere, and a perfect scanner.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "drivers/sim/film.h"
#include "drivers/sim/line_renderer.h"
#include "drivers/sim/optics_spec.h"

namespace reseau::sim {

class PlainRenderer final : public LineRenderer {
 public:
  PlainRenderer(std::shared_ptr<const Film> film, const OpticsSpec& optics,
                const ScanWindow& window);
  void transmittance(int first_line, int n_lines, std::span<float> out) const override;

 private:
  struct Kernel {
    int first_cell = 0;  // of weights[0], relative to the first cell of the pixel
    std::vector<float> weights;
  };
  struct RowCache;
  static Kernel make_kernel(double sigma_px, double aperture_px, int cells_per_px, bool tents);
  void convolve_rows(int first_line, int n_lines, std::span<float> out) const;
  void make_row(std::int64_t cell_row, RowCache& cache) const;

  std::shared_ptr<const Film> film_;
  ScanWindow window_;
  int cells_per_px_;
  bool point_rows_, tents_;  // so coarse a pitch that a line is a single row of cells
  std::array<Kernel, kChannels> kernels_;
  int reach_px_ = 0;  // of the longest kernel
  // Optical pixels of the window that see film; the others see the opaque holder.
  int active_begin_ = 0, n_active_ = 0;
};

}  // namespace reseau::sim
