#include "calibration/edge/residual_spline.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/check.h"

namespace reseau {
namespace {

constexpr std::size_t kPad = ResidualSpline::kDegree;

std::vector<double> right_knots(double spacing, double dense, double reach) {
  std::vector<double> out;
  double step = spacing;
  double at = 0.5 * spacing;
  const double widest = std::max(2.0, 2 * spacing);
  while (at < reach) {
    out.push_back(at);
    if (at > dense) step = std::min(1.25 * step, widest);
    at += step;
  }
  out.push_back(at);
  return out;
}

}  // namespace

ResidualSpline::ResidualSpline(double spacing_px, double dense_px, double reach_px) {
  CHECK(spacing_px > 0 && reach_px > 4 * spacing_px);
  const std::vector<double> right = right_knots(spacing_px, dense_px, reach_px);
  std::vector<double> inner;
  for (std::size_t i = right.size(); i-- > 0;) inner.push_back(-right[i]);
  inner.insert(inner.end(), right.begin(), right.end());
  CHECK(inner.size() > kDegree + 2);
  const double last_step = inner.back() - inner[inner.size() - 2];
  for (std::size_t i = 0; i < kPad; ++i) {
    knots_.push_back(inner.front() - last_step * double(kPad - i));
  }
  knots_.insert(knots_.end(), inner.begin(), inner.end());
  for (std::size_t i = 0; i < kPad; ++i) knots_.push_back(inner.back() + last_step * double(i + 1));
  n_ = inner.size() - kDegree - 1;

  jumps_.resize(n_);
  for (std::size_t j = 0; j < n_; ++j) {
    const double* t = &inner[j];
    const double span = t[kDegree + 1] - t[0];
    for (std::size_t i = 0; i < kDegree + 2; ++i) {
      double product = 1;
      for (std::size_t l = 0; l < kDegree + 2; ++l) {
        if (l != i) product *= t[i] - t[l];
      }
      jumps_[j][i] = 120 * span / product;
    }
  }
}

ResidualSpline::Active ResidualSpline::at(double d, int derivative) const {
  Active out;
  // Interval of the padded knots.
  const double low = knots_[kPad], high = knots_[knots_.size() - kPad - 1];
  if (!(d > low && d < high)) return out;
  const auto above = std::upper_bound(knots_.begin(), knots_.end(), d);
  const auto span = static_cast<std::size_t>(above - knots_.begin()) - 1;

  // Cox-de Boor up to degree 5 - derivative, then differences.
  std::array<double, kActive> basis{};
  basis[0] = 1;
  const int low_degree = kDegree - derivative;
  for (int degree = 1; degree <= kDegree; ++degree) {
    const bool differentiate = degree > low_degree;
    double carried = 0;
    for (int r = 0; r < degree; ++r) {
      const double right = knots_[span + static_cast<std::size_t>(r) + 1];
      const double left = knots_[span + static_cast<std::size_t>(r + 1 - degree)];
      const double share = basis[static_cast<std::size_t>(r)] / (right - left);
      if (differentiate) {
        basis[static_cast<std::size_t>(r)] = carried - degree * share;
        carried = degree * share;
      } else {
        basis[static_cast<std::size_t>(r)] = carried + (right - d) * share;
        carried = (d - left) * share;
      }
    }
    basis[static_cast<std::size_t>(degree)] = carried;
  }
  // basis[r] belongs to padded function span - 5 + r, which is function span - 10 + r of ours.
  for (std::size_t r = 0; r < kActive; ++r) {
    const std::size_t padded = span + r;
    if (padded < 2 * kPad || padded - 2 * kPad >= n_) continue;
    if (out.count == 0) out.first = padded - 2 * kPad;
    out.value[out.count++] = basis[r];
  }
  return out;
}

double ResidualSpline::value(std::span<const double> coefficients, double d, int derivative) const {
  const Active active = at(d, derivative);
  double sum = 0;
  for (std::size_t i = 0; i < active.count; ++i) {
    sum += active.value[i] * coefficients[active.first + i];
  }
  return sum;
}

Symmetric ResidualSpline::roughness(double scale_px) const {
  Symmetric out(n_);
  const double s5 = std::pow(scale_px, 5);
  constexpr std::array<double, 3> kAt = {0.1127016653792583, 0.5, 0.8872983346207417};
  constexpr std::array<double, 3> kWeight = {5.0 / 18, 8.0 / 18, 5.0 / 18};
  for (std::size_t i = kPad; i + kPad + 1 < knots_.size(); ++i) {
    const double width = knots_[i + 1] - knots_[i];
    for (std::size_t q = 0; q < 3; ++q) {
      const double d = knots_[i] + width * kAt[q];
      const Active active = at(d, 3);
      const double grow = 1 + std::abs(d) / (2 * scale_px);
      const double weight = s5 * width * kWeight[q] * std::pow(grow, 6);
      for (std::size_t a = 0; a < active.count; ++a) {
        for (std::size_t b = 0; b < active.count; ++b) {
          out(active.first + a, active.first + b) += weight * active.value[a] * active.value[b];
        }
      }
    }
  }
  return out;
}

void ResidualSpline::transform(double f, std::span<double> real,
                               std::span<double> imaginary) const {
  if (f == 0) {
    std::fill(real.begin(), real.end(), 0.0);
    std::fill(imaginary.begin(), imaginary.end(), 0.0);
    return;
  }
  const double w = 2 * std::numbers::pi * f;
  const double scale = -1 / std::pow(w, 5);
  const std::size_t n_inner = n_ + kDegree + 1;
  std::vector<double> sine(n_inner), cosine(n_inner);
  for (std::size_t i = 0; i < n_inner; ++i) {
    sine[i] = std::sin(w * knots_[kPad + i]);
    cosine[i] = std::cos(w * knots_[kPad + i]);
  }
  for (std::size_t j = 0; j < n_; ++j) {
    double s = 0, c = 0;
    for (std::size_t i = 0; i < kDegree + 2; ++i) {
      s += jumps_[j][i] * sine[j + i];
      c += jumps_[j][i] * cosine[j + i];
    }
    real[j] = scale * s;
    imaginary[j] = scale * c;
  }
}

}  // namespace reseau
