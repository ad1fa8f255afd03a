// Profile of an edge that EdgeOptics predicts: E(d) = 1/2 + int M(f) sin(2 pi f d) / (pi f) df.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "calibration/edge/optics.h"

namespace reseau {

// E and its slope, with derivatives by the parameters, tabulated once for one set of optics.
// Error below 1e-6 for every M whose slope at frequency 0 is that of a lens. Immutable.
class MeanProfile {
 public:
  static constexpr int kMost = kOpticsParameters + 1;

  // `parameters`: those whose derivatives are wanted. Valid for |d| <= reach_px <= 100.
  MeanProfile(const EdgeOptics& optics, const NormalCosines& normal, double reach_px,
              std::span<const int> parameters);

  struct At {
    double value = 0, slope = 0;
    std::array<double, kOpticsParameters> by_parameter{};
  };
  [[nodiscard]] At at(double d_px) const;
  // Value and slope with the parameters moved by `shift`, to first order; empty: not moved.
  [[nodiscard]] double value(double d_px, std::span<const double> shift = {}) const;
  [[nodiscard]] double slope(double d_px, std::span<const double> shift = {}) const;

 private:
  struct Cell {
    std::size_t left = 0;
    double step = 0, t = 0;
  };
  [[nodiscard]] Cell cell(double d) const;

  std::size_t columns_ = 1;
  double reach_px_ = 0;
  // [position][column][value, slope]
  std::vector<double> table_;
};

}  // namespace reseau
