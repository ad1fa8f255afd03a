// Optics: from a film to the light on the sensor.
#pragma once

#include <array>
#include <memory>
#include <span>

#include "drivers/sim/film.h"
#include "drivers/sim/line_renderer.h"
#include "drivers/sim/optics_spec.h"
#include "drivers/sim/scan_geometry.h"

namespace reseau::sim {

// Chooses the plain optics where they suffice, the full ones otherwise. Immutable after
// construction; thread-safe. Results do not depend on how a window is cut into calls, nor on the
// number of threads.
class ScanRenderer {
 public:
  ScanRenderer(std::shared_ptr<const Film> film, const OpticsSpec& optics, const ScanWindow& window,
               const ScanGeometry& geometry = {});

  [[nodiscard]] const ScanWindow& window() const { return window_; }
  // Transmittances after the optics, without noise: [line][channel R G B IR][pixel].
  void transmittance(int first_line, int n_lines, std::span<float> out) const;

 private:
  ScanWindow window_;
  std::unique_ptr<const LineRenderer> renderer_;
};

// How far a rendering is from the limit of ever finer cells, as transmittance (bare light = 1).
struct RenderError {
  double rms = 0, largest = 0;
  int cells_per_px = 0;  // of the rendering that was judged
  int n_samples = 0;
};

// A-posteriori estimate for a window: pieces spread over it, and half as many or fewer where the
// film is steepest, are rendered as they would be and once more with cells of half the side. The
// method converges with the square of the side, so the difference is three quarters of the error;
// the figures are four thirds of it. The largest is at least eight times the rms, for the worst
// sample is hardly among them. n_pieces of 16 x 4 samples each.
[[nodiscard]] RenderError estimate_error(const std::shared_ptr<const Film>& film,
                                         const OpticsSpec& optics, const ScanWindow& window,
                                         const ScanGeometry& geometry = {}, int n_pieces = 12);

// Whether a rendering takes tents for cells: where edges run along their borders, if the film knows
// them.
[[nodiscard]] bool takes_tents(const Film& film, int pitch);

// Cells per optical pixel that a rendering at this pitch uses; more for a film whose edges run
// along the axes of the scan. full: as OpticalRenderer.
[[nodiscard]] int cells_used(const Film& film, const OpticsSpec& optics, int pitch, bool full);

}  // namespace reseau::sim
