#include "calibration/random/spline_cells.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace reseau::random_target {
namespace {

// Integral of the cubic B-spline up to u.
double below(double u) {
  if (u > 0) return 1 - below(-u);
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

SplineCells::SplineCells(const RandomTarget& target, int n_knots, double step_px)
    : target_(target), n_knots_(n_knots), step_px_(step_px) {}

SplineCells::Axis SplineCells::axis(double at) const {
  const double cell = target_.cell_px, half = (n_knots_ / 2 + 2) * step_px_;
  Axis out;
  out.first = static_cast<std::int64_t>(std::floor((at - half) / cell));
  out.n =
      static_cast<int>(static_cast<std::int64_t>(std::floor((at + half) / cell)) - out.first) + 1;
  out.weight.resize(static_cast<std::size_t>(n_knots_) * static_cast<std::size_t>(out.n));
  for (int k = 0; k < n_knots_; ++k) {
    const double middle = at - (k - n_knots_ / 2) * step_px_;
    double before = below((static_cast<double>(out.first) * cell - middle) / step_px_);
    for (int c = 0; c < out.n; ++c) {
      const double end = below((static_cast<double>(out.first + c + 1) * cell - middle) / step_px_);
      out.weight[static_cast<std::size_t>(k * out.n + c)] = end - before;
      before = end;
    }
  }
  return out;
}

void SplineCells::features(double x, double y, std::span<double> out) const {
  const Axis across = axis(x), down = axis(y);
  const auto n = static_cast<std::size_t>(n_knots_);
  std::ranges::fill(out.first(n * n), 0.0);
  std::vector<double> row(n);
  for (int j = 0; j < down.n; ++j) {
    std::ranges::fill(row, 0.0);
    for (int i = 0; i < across.n; ++i) {
      if (!random_cell(target_.seed, across.first + i, down.first + j)) continue;
      for (std::size_t k = 0; k < n; ++k) {
        row[k] +=
            across.weight[k * static_cast<std::size_t>(across.n) + static_cast<std::size_t>(i)];
      }
    }
    for (std::size_t ky = 0; ky < n; ++ky) {
      const double w =
          down.weight[ky * static_cast<std::size_t>(down.n) + static_cast<std::size_t>(j)];
      if (w == 0) continue;
      for (std::size_t kx = 0; kx < n; ++kx) out[ky * n + kx] += w * row[kx];
    }
  }
}

}  // namespace reseau::random_target
