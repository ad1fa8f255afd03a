#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace reseau::sim {

// Smooth random field: cubic B-spline with uniform random coefficients on a square grid. Twice
// differentiable, band-limited to about one cycle per two cells, within [-1, 1]. Immutable,
// thread-safe; the value at a point depends on the seed and the point only.
class SplineNoise {
 public:
  SplineNoise(std::uint64_t seed, double cell_px) : seed_(seed), cell_px_(cell_px) {}

  // out[i] += gain * field(x0 + i, y).
  void add_row(double y, double x0, float gain, std::span<float> out) const;

 private:
  std::uint64_t seed_;
  double cell_px_;
};

}  // namespace reseau::sim
