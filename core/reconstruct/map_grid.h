// The registration of a rectangle of pixels, there and back, fast.
#pragma once

#include <vector>

#include "core/geometry/pixel_bounds.h"
#include "core/geometry/vec2.h"
#include "core/screen/screen_map.h"

namespace reseau {

struct ScreenPoint {
  float u = 0, v = 0;
};

// Screen coordinates of pixels relative to a whole period near the rectangle, so that float holds
// them well. `shift_px`: pixel p shows what the map says of p - shift. Immutable, thread-safe.
class MapGrid {
 public:
  MapGrid(const ScreenMap& map, Vec2 shift_px, const PixelBounds& rect, Vec2 origin);

  [[nodiscard]] Vec2 lowest() const { return lowest_; }
  [[nodiscard]] Vec2 highest() const { return highest_; }
  // Of the pixels of row y from the rectangle's left to its right.
  void row(int y, std::vector<ScreenPoint>& out) const;

 private:
  // A bend of 6 px over 700 px errs by 0.001 px between nodes.
  static constexpr int kStep = 8;
  [[nodiscard]] const Vec2& node(int i, int j) const {
    return nodes_[static_cast<std::size_t>(j) * static_cast<std::size_t>(columns_) +
                  static_cast<std::size_t>(i)];
  }
  PixelBounds rect_;
  int columns_;
  std::vector<Vec2> nodes_;
  Vec2 lowest_{1e30, 1e30}, highest_{-1e30, -1e30};
};

// Scan pixels of points of the réseau. Immutable, thread-safe.
class InverseMapGrid {
 public:
  // Covers screen coordinates `lowest` to `highest`, relative to `origin`; the rectangle holds
  // them.
  InverseMapGrid(const ScreenMap& map, Vec2 shift_px, const PixelBounds& rect, Vec2 origin,
                 Vec2 lowest, Vec2 highest);
  [[nodiscard]] Vec2 at(Vec2 s) const;

 private:
  static constexpr double kStepPeriods = 2;
  bool affine_;
  Mat2 inverse_;
  Vec2 offset_;  // affine: of scan coordinates; else the first node
  int columns_ = 0, rows_ = 0;
  std::vector<Vec2> nodes_;
};

}  // namespace reseau
