// How alike a picture is at two places a distance apart, before it is seen.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace reseau {

// A variance that decays as exp(-r / length); an infinite length makes it an unknown constant.
struct CovarianceTerm {
  double variance = 0;
  double length_px = 0;
};

// Sum of terms, seen through a Gaussian blur of its argument. Each exponential is a sum of
// Gaussians, which a Gaussian blurs exactly, so matrices of it stay positive. Immutable,
// thread-safe.
class RadialCovariance {
 public:
  RadialCovariance(std::span<const CovarianceTerm> terms, double blur_px);

  // By the square of the distance, in which it is smooth; linear in a table, the last value beyond.
  [[nodiscard]] double at_square(double distance_squared_px2) const {
    const double x = distance_squared_px2 * kPerPx2;
    const auto i = static_cast<std::size_t>(x);
    if (i + 1 >= table_.size()) return table_.back();
    const double f = x - static_cast<double>(i);
    return table_[i] + f * (table_[i + 1] - table_[i]);
  }

 private:
  static constexpr double kPerPx2 = 32, kReachPx = 26;
  std::vector<double> table_;
};

}  // namespace reseau
