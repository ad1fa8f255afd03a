// What pixels see of the random target through each knot of the spread function. Part of
// measure_random.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "calibration/random/random_target.h"

namespace reseau::random_target {

class SplineCells {
 public:
  SplineCells(const RandomTarget& target, int n_knots, double step_px);

  // out[ky * n_knots + kx]: light of the cells through the cubic B-spline of integral 1 at knot
  // (kx, ky), for a pixel whose centre lies at (x, y) of the target.
  void features(double x, double y, std::span<double> out) const;

 private:
  struct Axis {
    std::int64_t first = 0;      // cell
    int n = 0;                   // cells
    std::vector<double> weight;  // [knot][cell]
  };
  [[nodiscard]] Axis axis(double at) const;

  RandomTarget target_;
  int n_knots_;
  double step_px_;
};

// Cubic B-spline with its middle at 0 and knots 1 apart, integral 1.
[[nodiscard]] double cubic_spline(double u);

}  // namespace reseau::random_target
