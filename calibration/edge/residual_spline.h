// What a measured edge profile adds to the physical one: a quintic spline of the distance, zero
// beyond its ends, dense in the middle. Immutable.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "calibration/edge/dense.h"

namespace reseau {

class ResidualSpline {
 public:
  static constexpr int kDegree = 5;
  static constexpr std::size_t kActive = kDegree + 1;

  // Knots `spacing_px` apart within +-`dense_px`, then ever farther up to `reach_px`.
  ResidualSpline(double spacing_px, double dense_px, double reach_px);

  [[nodiscard]] std::size_t size() const { return n_; }
  // Basis functions first .. first + count - 1 are the ones that are not zero at d.
  struct Active {
    std::size_t first = 0, count = 0;
    std::array<double, kActive> value{};
  };
  // derivative 0 to 3.
  [[nodiscard]] Active at(double d_px, int derivative = 0) const;
  [[nodiscard]] double value(std::span<const double> coefficients, double d_px,
                             int derivative = 0) const;

  // Roughness, scale^5 int (r''')^2 (1 + |d| / (2 scale))^6 dd: what the penalty multiplies.
  [[nodiscard]] Symmetric roughness(double scale_px) const;
  // Closed form of int r'(d) exp(-2 pi i f d) dd for every basis function.
  void transform(double f_cy_per_px, std::span<double> real, std::span<double> imaginary) const;

 private:
  std::vector<double> knots_;  // with kDegree more on both sides
  std::size_t n_ = 0;
  // Jumps of the fifth derivative of function j at knots j .. j + 6 (of the inner knots).
  std::vector<std::array<double, kDegree + 2>> jumps_;
};

}  // namespace reseau
