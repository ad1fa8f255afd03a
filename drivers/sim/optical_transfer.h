// The optical transfer function of one channel, and its point spread function on a grid.
#pragma once

#include <vector>

#include "drivers/sim/optics_spec.h"

namespace reseau::sim {

// Transfer of a lens with a round, evenly lit pupil at the normalised frequency (s_x, s_y), |s| = 1
// at the cutoff 1 / (wavelength x f-number), whose wavefront is wrong by w_x p_x^2 + w_y p_y^2
// waves at pupil position p (|p| <= 1). Real and even. Hopkins' integral (Proc. R. Soc. A 231,
// 1955), the inner one in closed form, the outer by Gauss and Legendre's rule to 1e-12.
[[nodiscard]] double lens_transfer(double s_x, double s_y, double w_x, double w_y);

// [(1 - halo) lens x Gaussian core + halo's Gaussian] x aperture; frequencies in cycles per optical
// pixel, x along the sensor. Flare is not part of it. Immutable, thread-safe.
class OpticalTransfer {
 public:
  OpticalTransfer(const OpticsSpec& optics, int channel);

  // defocus_um: distance from best focus.
  [[nodiscard]] double operator()(double f_x, double f_y, double defocus_um) const;
  // Lens and core alone.
  [[nodiscard]] double sharp(double f_x, double f_y, double defocus_um) const;
  [[nodiscard]] double aperture(double f_x, double f_y) const;
  [[nodiscard]] double halo(double f_squared) const;

  [[nodiscard]] bool has_lens() const { return cutoff_ > 0; }
  // Of the lens [cycles/px]; 0 without one.
  [[nodiscard]] double cutoff() const { return cutoff_; }
  [[nodiscard]] double waves(double defocus_um) const { return defocus_um * waves_per_um_; }
  [[nodiscard]] double astigmatism_um() const { return astigmatism_um_; }
  [[nodiscard]] double core_px() const { return core_px_; }
  [[nodiscard]] double halo_fraction() const { return halo_fraction_; }
  [[nodiscard]] double halo_px() const { return halo_px_; }
  [[nodiscard]] double aperture_x_px() const { return aperture_x_px_; }
  [[nodiscard]] double aperture_y_px() const { return aperture_y_px_; }

 private:
  double cutoff_ = 0, waves_per_um_ = 0, astigmatism_um_ = 0;
  double core_px_, halo_fraction_, halo_px_, aperture_x_px_, aperture_y_px_;
};

// A point spread function on a square grid.
struct PsfGrid {
  int samples_per_px = 1;
  int radius_px = 0;
  int side = 0;                // 2 * radius_px * samples_per_px + 1
  std::vector<double> values;  // [y][x], light per optical px squared; the middle is the axis
};

// The spread function of a channel (0 to 3: R G B IR) that far from best focus, aperture included,
// without lateral colour and flare. Its tails beyond the radius are left out, so the values add up
// to a little less than samples_per_px squared. Throws InputError for fewer than 1 sample per px, a
// radius outside 1..256 or a grid of more than 4096 a side.
[[nodiscard]] PsfGrid sample_psf(const OpticsSpec& optics, int channel, double defocus_um,
                                 int samples_per_px, int radius_px);

}  // namespace reseau::sim
