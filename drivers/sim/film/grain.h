// Granularity of the silver.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace reseau::sim {

// A texture m = exp(q n - q^2 / 2) - 1 with n a random field of unit variance on the film: cubic
// B-splines on a square grid of knots, spectrum sinc^8(f knot) per axis. Silver of transmittance T
// becomes T + g(T) m: its mean stays. g = T a sqrt(D), so that the mean over a square pixel has the
// relative rms `amount` sqrt(D) at density D (Nutting 1913: a layer of opaque grains of area a has
// a variance of density of 0.434 a D over a unit of area). m depends on the place alone and is
// smooth over less than a knot: its mean over any cell is known. Immutable, thread-safe.
class Grain {
 public:
  // amount: relative rms of a pixel's transmittance at density 1; knot_px: spacing of the knots.
  Grain(double amount, double knot_px, std::uint64_t seed);

  [[nodiscard]] bool is_off() const { return amount_ == 0; }
  // m at film positions (x0 + i * step_px, y).
  void texture(double y, double x0, double step_px, std::span<float> out) const;
  // g of every transmittance; as many of both.
  void depths(std::span<const float> silver, std::span<float> depth) const;
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
  float contrast_ = 0;   // q
  float per_depth_ = 0;  // a, where densities are powers of 2
};

}  // namespace reseau::sim
