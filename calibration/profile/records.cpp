#include "calibration/profile/records.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

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

namespace {

constexpr std::array<std::size_t, 3> kTermsOfOrder{1, 3, 6};

}  // namespace

const PsfFieldRecord::Surface* PsfFieldRecord::find(const std::string& name) const {
  for (const Surface& s : surfaces) {
    if (s.name == name) return &s;
  }
  return nullptr;
}

std::vector<double> PsfFieldRecord::weights(const std::string& name, double x, double y) const {
  const std::array<double, 6> terms{1, x, y, x * x, x * y, y * y};
  std::vector<double> out(coefficients.size());
  std::size_t first = 0;
  for (const Surface& s : surfaces) {
    const std::size_t n = kTermsOfOrder[static_cast<std::size_t>(s.order)];
    for (std::size_t i = 0; s.name == name && i < n; ++i) out[first + i] = terms[i];
    first += n;
  }
  return out;
}

std::optional<Measured> PsfFieldRecord::at(const std::string& name, double x, double y) const {
  if (find(name) == nullptr) return std::nullopt;
  const std::vector<double> w = weights(name, x, y);
  const std::size_t n = w.size();
  Measured out;
  double variance = 0;
  for (std::size_t i = 0; i < n; ++i) {
    out.value += w[i] * coefficients[i];
    for (std::size_t k = 0; k < n; ++k) variance += w[i] * covariance[i * n + k] * w[k];
  }
  out.sd = std::sqrt(variance > 0 ? variance : 0.0);
  return out;
}

}  // namespace reseau
