#pragma once

namespace reseau {

// A rectangle of pixels by its bounds, the upper ones excluded.
struct PixelBounds {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  [[nodiscard]] int width() const { return x1 - x0; }
  [[nodiscard]] int height() const { return y1 - y0; }
  [[nodiscard]] PixelBounds grown(int by) const { return {x0 - by, y0 - by, x1 + by, y1 + by}; }
};

}  // namespace reseau
