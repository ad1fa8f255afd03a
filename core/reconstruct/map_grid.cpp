#include "core/reconstruct/map_grid.h"

#include <algorithm>
#include <cmath>

namespace reseau {

MapGrid::MapGrid(const ScreenMap& map, Vec2 shift_px, const PixelBounds& rect, Vec2 origin)
    : rect_(rect), columns_((rect.width() + kStep - 1) / kStep + 1) {
  const int rows = (rect.height() + kStep - 1) / kStep + 1;
  nodes_.reserve(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows));
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns_; ++i) {
      const Vec2 p{static_cast<double>(rect.x0 + i * kStep),
                   static_cast<double>(rect.y0 + j * kStep)};
      const Vec2 s = map.screen_from_scan(p - shift_px) - origin;
      nodes_.push_back(s);
      lowest_ = {std::min(lowest_.x, s.x), std::min(lowest_.y, s.y)};
      highest_ = {std::max(highest_.x, s.x), std::max(highest_.y, s.y)};
    }
  }
}

void MapGrid::row(int y, std::vector<ScreenPoint>& out) const {
  out.resize(static_cast<std::size_t>(rect_.width()));
  const int j = (y - rect_.y0) / kStep;
  const double fy = static_cast<double>(y - rect_.y0 - j * kStep) / kStep;
  for (int i = 0; i + 1 < columns_; ++i) {
    const Vec2 a = node(i, j) + fy * (node(i, j + 1) - node(i, j));
    const Vec2 b = node(i + 1, j) + fy * (node(i + 1, j + 1) - node(i + 1, j));
    const auto u = static_cast<float>(a.x), v = static_cast<float>(a.y);
    const auto du = static_cast<float>((b.x - a.x) / kStep),
               dv = static_cast<float>((b.y - a.y) / kStep);
    const int first = i * kStep, n = std::min(kStep, rect_.width() - first);
    ScreenPoint* to = &out[static_cast<std::size_t>(first)];
    for (int k = 0; k < n; ++k) {
      const auto t = static_cast<float>(k);
      to[k] = {u + t * du, v + t * dv};
    }
  }
}

InverseMapGrid::InverseMapGrid(const ScreenMap& map, Vec2 shift_px, const PixelBounds& rect,
                               Vec2 origin, Vec2 lowest, Vec2 highest)
    : affine_(map.is_affine()), inverse_(map.linear().inverse()) {
  if (affine_) {
    offset_ = inverse_ * (origin - map.offset()) + shift_px;
    return;
  }
  offset_ = lowest;
  columns_ = static_cast<int>(std::ceil((highest.x - lowest.x) / kStepPeriods)) + 2;
  rows_ = static_cast<int>(std::ceil((highest.y - lowest.y) / kStepPeriods)) + 2;
  const Vec2 middle{0.5 * (rect.x0 + rect.x1), 0.5 * (rect.y0 + rect.y1)};
  const Vec2 s_middle = map.screen_from_scan(middle);
  const Mat2 scan_from_screen = map.jacobian(middle).inverse();
  for (int j = 0; j < rows_; ++j) {
    for (int i = 0; i < columns_; ++i) {
      const Vec2 s = origin + lowest + Vec2{i * kStepPeriods, j * kStepPeriods};
      const Vec2 guess = middle + scan_from_screen * (s - s_middle);
      nodes_.push_back(map.scan_from_screen(s, guess) + shift_px);
    }
  }
}

Vec2 InverseMapGrid::at(Vec2 s) const {
  if (affine_) return inverse_ * s + offset_;
  const double x = (s.x - offset_.x) / kStepPeriods, y = (s.y - offset_.y) / kStepPeriods;
  const int i = std::clamp(static_cast<int>(std::floor(x)), 0, columns_ - 2),
            j = std::clamp(static_cast<int>(std::floor(y)), 0, rows_ - 2);
  const Vec2* a = &nodes_[static_cast<std::size_t>(j) * static_cast<std::size_t>(columns_) +
                          static_cast<std::size_t>(i)];
  const Vec2* b = a + columns_;
  const Vec2 top = a[0] + (x - i) * (a[1] - a[0]), bottom = b[0] + (x - i) * (b[1] - b[0]);
  return top + (y - j) * (bottom - top);
}

}  // namespace reseau
