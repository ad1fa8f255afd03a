#include "core/screen/screen_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/base/check.h"

namespace reseau {
namespace {

// The four cubic B-spline weights and their derivatives at t in [0, 1).
struct Weights {
  std::array<double, 4> value;
  std::array<double, 4> slope;
};

Weights spline_weights(double t) {
  const double s = 1 - t;
  return {{s * s * s / 6, (3 * t * t * t - 6 * t * t + 4) / 6,
           (-3 * t * t * t + 3 * t * t + 3 * t + 1) / 6, t * t * t / 6},
          {-s * s / 2, (3 * t * t - 4 * t) / 2, (-3 * t * t + 2 * t + 1) / 2, t * t / 2}};
}

// Interval of the knot grid that holds `position`, clamped so that outside the grid the last
// interval is used at its border: the displacement is held constant there, never extrapolated.
struct Interval {
  int index;
  double t;
  bool inside;
};

Interval locate(double position, double spacing, int n_coefficients) {
  const double cell = position / spacing;
  const double last = n_coefficients - 3;
  const double clamped = std::clamp(cell, 0.0, last);
  const int index = std::min(static_cast<int>(clamped), n_coefficients - 4);
  return {index, clamped - index, cell >= 0 && cell <= last};
}

}  // namespace

ScreenMap::ScreenMap(Mat2 linear, Vec2 offset) : linear_(linear), offset_(offset) {}

ScreenMap::ScreenMap(Mat2 linear, Vec2 offset, double spacing_px, int n_columns, int n_rows,
                     std::vector<Vec2> coefficients)
    : linear_(linear),
      offset_(offset),
      spacing_px_(spacing_px),
      n_columns_(n_columns),
      n_rows_(n_rows),
      coefficients_(std::move(coefficients)) {
  CHECK(spacing_px > 0 && n_columns >= 4 && n_rows >= 4);
  CHECK(coefficients_.size() ==
        static_cast<std::size_t>(n_columns) * static_cast<std::size_t>(n_rows));
}

Vec2 ScreenMap::screen_from_scan(Vec2 p) const {
  Vec2 s = linear_ * p + offset_;
  if (is_affine()) return s;
  const Interval x = locate(p.x, spacing_px_, n_columns_);
  const Interval y = locate(p.y, spacing_px_, n_rows_);
  const Weights wx = spline_weights(x.t);
  const Weights wy = spline_weights(y.t);
  for (std::size_t j = 0; j < 4; ++j) {
    const Vec2* row = &coefficients_[(static_cast<std::size_t>(y.index) + j) *
                                         static_cast<std::size_t>(n_columns_) +
                                     static_cast<std::size_t>(x.index)];
    for (std::size_t i = 0; i < 4; ++i) s = s + (wx.value[i] * wy.value[j]) * row[i];
  }
  return s;
}

Mat2 ScreenMap::jacobian(Vec2 p) const {
  Mat2 result = linear_;
  if (is_affine()) return result;
  const Interval x = locate(p.x, spacing_px_, n_columns_);
  const Interval y = locate(p.y, spacing_px_, n_rows_);
  const Weights wx = spline_weights(x.t);
  const Weights wy = spline_weights(y.t);
  Vec2 dx, dy;
  for (std::size_t j = 0; j < 4; ++j) {
    const Vec2* row = &coefficients_[(static_cast<std::size_t>(y.index) + j) *
                                         static_cast<std::size_t>(n_columns_) +
                                     static_cast<std::size_t>(x.index)];
    for (std::size_t i = 0; i < 4; ++i) {
      if (x.inside) dx = dx + (wx.slope[i] * wy.value[j] / spacing_px_) * row[i];
      if (y.inside) dy = dy + (wx.value[i] * wy.slope[j] / spacing_px_) * row[i];
    }
  }
  result.a += dx.x;
  result.c += dx.y;
  result.b += dy.x;
  result.d += dy.y;
  return result;
}

Vec2 ScreenMap::scan_from_screen(Vec2 s, Vec2 guess) const {
  Vec2 p = guess;
  for (int iteration = 0; iteration < 20; ++iteration) {
    const Vec2 step = jacobian(p).inverse() * (s - screen_from_scan(p));
    p = p + step;
    if (norm(step) < 1e-9) break;
  }
  return p;
}

}  // namespace reseau
