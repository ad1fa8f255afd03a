// What pixels see of the random target through each knot of the spread function. Part of
// measure_random.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "calibration/random/random_cells.h"

namespace reseau::random_target {

// Thread-bound.
class SplineCells {
 public:
  // Knots lie step_px apart, n_knots (odd) along either axis of the target.
  SplineCells(const RandomCells& cells, int n_knots, double step_px);

  // out[kv * n_knots + ku]: light of the cells through the cubic B-spline of integral 1 at knot
  // (ku, kv), for a pixel whose centre lies at (u, v) of the target. Exact.
  void features(double u, double v, std::span<double> out);

 private:
  struct Axis {
    std::int64_t first = 0;      // cell
    int n = 0;                   // cells
    std::vector<int> from, to;   // of each knot: the cells that it sees
    std::vector<double> weight;  // [knot][cell]
  };
  void set_axis(double at, Axis& axis) const;

  const RandomCells& cells_;
  int n_knots_;
  double step_px_;
  Axis across_, down_;
  std::vector<double> row_, clear_;
};

// Where knot or sample k of n (odd) lies, from the middle one.
[[nodiscard]] inline double from_middle(std::ptrdiff_t k, std::ptrdiff_t n) {
  const std::ptrdiff_t away = k - n / 2;
  return static_cast<double>(away);
}

// Cubic B-spline with its middle at 0 and knots 1 apart, integral 1; its slope.
[[nodiscard]] double cubic_spline(double u);
[[nodiscard]] double cubic_spline_slope(double u);

}  // namespace reseau::random_target
