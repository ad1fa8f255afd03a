#include "calibration/random/spline_cells.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace reseau::random_target {
namespace {

// Integral of the cubic B-spline up to u.
double integral_below(double u) {
  if (u > 0) return 1 - integral_below(-u);
  if (u <= -2) return 0;
  if (u <= -1) {
    const double v = (u + 2) * (u + 2);
    return v * v / 24;
  }
  return 0.5 + u * (2.0 / 3 - u * u * (1.0 / 3 + u / 8));
}

}  // namespace

double cubic_spline(double u) {
  u = std::abs(u);
  if (u >= 2) return 0;
  if (u >= 1) return (2 - u) * (2 - u) * (2 - u) / 6;
  return 2.0 / 3 - u * u * (1 - u / 2);
}

double cubic_spline_slope(double u) {
  const double a = std::abs(u), sign = u < 0 ? -1 : 1;
  if (a >= 2) return 0;
  if (a >= 1) return -sign * (2 - a) * (2 - a) / 2;
  return sign * a * (1.5 * a - 2);
}

SplineCells::SplineCells(const RandomCells& cells, int n_knots, double step_px)
    : cells_(cells), n_knots_(n_knots), step_px_(step_px) {
  row_.resize(static_cast<std::size_t>(n_knots));
}

void SplineCells::set_axis(double at, Axis& axis) const {
  const double half = (0.5 * n_knots_ + 1.5) * step_px_;
  axis.first = cells_.cell_at(at - half);
  axis.n = static_cast<int>(cells_.cell_at(at + half) - axis.first) + 1;
  const auto n_knots = static_cast<std::size_t>(n_knots_), n = static_cast<std::size_t>(axis.n);
  axis.weight.assign(n_knots * n, 0.0);
  axis.from.assign(n_knots, 0);
  axis.to.assign(n_knots, 0);
  for (std::size_t k = 0; k < n_knots; ++k) {
    // Light that falls beside its place by +s comes from -s.
    const double middle = at - from_middle(static_cast<std::ptrdiff_t>(k), n_knots_) * step_px_;
    const auto last = static_cast<int>(cells_.cell_at(middle + 2 * step_px_) - axis.first);
    axis.from[k] =
        std::max(0, static_cast<int>(cells_.cell_at(middle - 2 * step_px_) - axis.first));
    axis.to[k] = std::min(axis.n, last + 1);
    const auto upto = [&](int c) {
      return integral_below((cells_.border_px(axis.first + c) - middle) / step_px_);
    };
    double before = upto(axis.from[k]);
    for (int c = axis.from[k]; c < axis.to[k]; ++c) {
      const double end = upto(c + 1);
      axis.weight[k * n + static_cast<std::size_t>(c)] = end - before;
      before = end;
    }
  }
}

void SplineCells::features(double u, double v, std::span<double> out) {
  set_axis(u, across_);
  set_axis(v, down_);
  const auto n = static_cast<std::size_t>(n_knots_);
  std::ranges::fill(out.first(n * n), 0.0);
  clear_.resize(static_cast<std::size_t>(across_.n));
  for (int j = 0; j < down_.n; ++j) {
    for (int i = 0; i < across_.n; ++i) {
      clear_[static_cast<std::size_t>(i)] =
          cells_.clear(across_.first + i, down_.first + j) ? 1.0 : 0.0;
    }
    for (std::size_t k = 0; k < n; ++k) {
      const double* const w = across_.weight.data() + k * static_cast<std::size_t>(across_.n);
      double sum = 0;
      for (int i = across_.from[k]; i < across_.to[k]; ++i) {
        sum += w[i] * clear_[static_cast<std::size_t>(i)];
      }
      row_[k] = sum;
    }
    for (std::size_t kv = 0; kv < n; ++kv) {
      if (j < down_.from[kv] || j >= down_.to[kv]) continue;
      const double w =
          down_.weight[kv * static_cast<std::size_t>(down_.n) + static_cast<std::size_t>(j)];
      for (std::size_t ku = 0; ku < n; ++ku) out[kv * n + ku] += w * row_[ku];
    }
  }
}

}  // namespace reseau::random_target
