// The full optics: spread functions that change with channel and place, light that strays far,
// lens distortion, lateral colour, and lines that lie where the stage really was.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "drivers/sim/far_field.h"
#include "drivers/sim/film.h"
#include "drivers/sim/focus_map.h"
#include "drivers/sim/line_renderer.h"
#include "drivers/sim/optics_spec.h"
#include "drivers/sim/psf_family.h"
#include "drivers/sim/scan_geometry.h"

namespace reseau::sim {

// Every sample is an integral over the film, which stays on its own regular grid of cells: along y
// first, at the displaced place of the line and once per separable component, then along x at the
// place that the lens shows the pixel, with weights for its distance from focus.
class OpticalRenderer final : public LineRenderer {
 public:
  // From pitch 4 on diffraction and defocus are replaced by a Gaussian and cells are whole pixels.
  OpticalRenderer(std::shared_ptr<const Film> film, const OpticsSpec& optics,
                  const ScanWindow& window, const ScanGeometry& geometry);
  ~OpticalRenderer() override;
  OpticalRenderer(const OpticalRenderer&) = delete;
  OpticalRenderer& operator=(const OpticalRenderer&) = delete;
  OpticalRenderer(OpticalRenderer&&) = delete;
  OpticalRenderer& operator=(OpticalRenderer&&) = delete;
  void transmittance(int first_line, int n_lines, std::span<float> out) const override;

 private:
  struct Work;
  struct Line;
  struct Pool;
  void render(int first_line, int n_lines, std::span<float> out) const;
  void load_rows(std::int64_t first, std::int64_t last, Work& work) const;
  [[nodiscard]] double looks_at(const Line& line, int channel) const;
  // Of the first n lines of a batch.
  void sum_along_y(int n_lines, int channel, Work& work) const;
  void sum_along_x(const Line& line, int channel, Work& work, std::span<float> out) const;
  void set_focus_range(double& low, double& high) const;

  std::shared_ptr<const Film> film_;
  OpticsSpec optics_;
  ScanWindow window_;
  ScanGeometry geometry_;
  FocusMap focus_;
  CellGrid grid_;
  std::vector<PsfFamily> families_;  // one per channel
  std::unique_ptr<FarField> far_;
  bool focus_varies_ = false;
  // Optical pixels of the window that see film; the others see the opaque holder.
  int active_begin_ = 0, n_active_ = 0;
  // Where the lens lets them look, per channel, and whether that is one pixel on each time.
  std::array<std::vector<double>, kChannels> x_place_;
  bool regular_x_ = true;
  int first_px_ = 0, n_px_ = 0;  // of the cells
  int reach_cells_ = 0;
  std::unique_ptr<Pool> pool_;
};

}  // namespace reseau::sim
