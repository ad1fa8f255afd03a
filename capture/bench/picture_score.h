// How far a reconstruction is from the scene that a simulated film holds.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/reconstruct/row_sink.h"
#include "drivers/sim/simulate.h"

namespace reseau {

// A whole reconstruction in memory.
class PictureInMemory final : public RgbRowSink {
 public:
  void begin(int width_px, int height_px) override;
  void rows(int first_row, int n_rows, std::span<const float> rgb) override;
  void end() override { ended_ = true; }

  [[nodiscard]] int width_px() const { return width_px_; }
  [[nodiscard]] int height_px() const { return height_px_; }
  [[nodiscard]] bool ended() const { return ended_; }
  [[nodiscard]] const std::vector<float>& rgb() const { return rgb_; }

 private:
  int width_px_ = 0, height_px_ = 0;
  bool ended_ = false;
  std::vector<float> rgb_;  // [row][pixel][R G B]
};

// Colour differences are CIEDE2000 of process RGB taken as linear sRGB.
struct PictureScore {
  double full_mean = 0, full_p99 = 0;        // pixel by pixel
  double psnr_db = 0;                        // of process RGB, 1 = clear film
  double element_mean = 0, element_p95 = 0;  // after a Gaussian of 0.45 period on both
  double patch_mean = 0, patch_max = 0;      // means of flat fields of 12 x 12 elements and more
  int n_patches = 0;
};

// period_px: of the réseau; fields of the scene smaller than 12 periods do not count as patches.
[[nodiscard]] PictureScore score_picture(const sim::FilmTruth& truth, double period_px,
                                         const PictureInMemory& picture, int n_threads);

}  // namespace reseau
