// Granularity of the silver.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "drivers/sim/film/log_table.h"

namespace reseau::sim {

// Multiplies transmittances by exp(s n - s^2 / 2) with n a random field of unit variance on the
// film: cubic B-splines on a square grid of knots, spectrum sinc^8(f knot) per axis. The mean
// transmittance stays. s grows with the root of the density D (Nutting 1913: a layer of opaque
// grains of area a has a variance of density of 0.434 a D over a unit of area), so that the mean
// over a square pixel has the relative rms `amount` sqrt(D). Immutable, thread-safe; the field
// depends on seed and place only.
class Grain {
 public:
  // amount: relative rms of a pixel's transmittance at density 1; knot_px: spacing of the knots.
  Grain(double amount, double knot_px, std::uint64_t seed);

  [[nodiscard]] bool is_off() const { return amount_ == 0; }
  // Factor for silver of transmittance silver[i] at film position (x0 + i * step_px, y).
  void factors(double y, double x0, double step_px, std::span<const float> silver,
               std::span<float> factor) const;
  // The field itself.
  void field(double y, double x0, double step_px, std::span<float> out) const;
  // Standard deviation of the mean of the field over a square pixel.
  [[nodiscard]] double pixel_rms() const { return pixel_rms_; }

 private:
  void knot_row(std::int64_t iy, std::int64_t first, std::span<float> out) const;
  double amount_, knot_px_;
  std::uint64_t seed_, id_;
  double gain_ = 1;  // to unit variance
  double pixel_rms_ = 1;
  LogTable strength_;  // s as a function of the transmittance
};

}  // namespace reseau::sim
