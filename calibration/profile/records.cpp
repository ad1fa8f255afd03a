#include "calibration/profile/records.h"

#include <cmath>
#include <cstddef>

namespace reseau {

Measured FieldRecord::at(double x, double y) const {
  const std::array<double, 6> terms{1, x, y, x * x, x * y, y * y};
  const std::size_t n = coefficients.size();
  Measured out;
  double variance = 0;
  for (std::size_t i = 0; i < n; ++i) {
    out.value += terms[i] * coefficients[i];
    for (std::size_t k = 0; k < n; ++k) variance += terms[i] * covariance[i * n + k] * terms[k];
  }
  out.sd = std::sqrt(variance > 0 ? variance : 0.0);
  return out;
}

}  // namespace reseau
