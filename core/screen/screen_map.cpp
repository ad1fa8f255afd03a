#include "core/screen/screen_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/base/check.h"
#include "core/screen/cubic_spline.h"

namespace reseau {
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

ScreenMap ScreenMap::shifted(Vec2 by) const {
  ScreenMap map = *this;
  map.offset_ = offset_ + by;
  return map;
}

ScreenMap ScreenMap::with_line_error(LineError line) const {
  CHECK(line.none() || (line.spacing_px > 0 && line.coefficients.size() >= 4));
  ScreenMap map = *this;
  map.line_ = std::move(line);
  return map;
}

Vec2 ScreenMap::screen_from_scan(Vec2 p_in_scan) const {
  return smooth_screen_from_scan(p_in_scan + line_.at(p_in_scan));
}

Vec2 ScreenMap::smooth_screen_from_scan(Vec2 p) const {
  Vec2 s = linear_ * p + offset_;
  if (coefficients_.empty()) return s;
  const SplineInterval x = locate_interval(p.x, spacing_px_, n_columns_);
  const SplineInterval y = locate_interval(p.y, spacing_px_, n_rows_);
  const SplineWeights wx = spline_weights(x.t);
  const SplineWeights wy = spline_weights(y.t);
  for (std::size_t j = 0; j < 4; ++j) {
    const Vec2* row = &coefficients_[(static_cast<std::size_t>(y.index) + j) *
                                         static_cast<std::size_t>(n_columns_) +
                                     static_cast<std::size_t>(x.index)];
    for (std::size_t i = 0; i < 4; ++i) s = s + (wx.value[i] * wy.value[j]) * row[i];
  }
  return s;
}

Mat2 ScreenMap::jacobian(Vec2 p_in_scan) const {
  const Mat2 smooth = smooth_jacobian(p_in_scan + line_.at(p_in_scan));
  if (line_.none()) return smooth;
  const Vec2 slope = line_.slope_at(p_in_scan);
  Mat2 bent;
  if (line_.axis == LineError::Axis::kColumns) {
    bent.a += slope.x;
    bent.c += slope.y;
  } else {
    bent.b += slope.x;
    bent.d += slope.y;
  }
  return smooth * bent;
}

Mat2 ScreenMap::smooth_jacobian(Vec2 p) const {
  Mat2 result = linear_;
  if (coefficients_.empty()) return result;
  const SplineInterval x = locate_interval(p.x, spacing_px_, n_columns_);
  const SplineInterval y = locate_interval(p.y, spacing_px_, n_rows_);
  const SplineWeights wx = spline_weights(x.t);
  const SplineWeights wy = spline_weights(y.t);
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
