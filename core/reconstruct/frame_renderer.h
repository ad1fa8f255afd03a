// A picture that is turned, scaled, straightened or cut out of the scan.
#pragma once

#include <cstddef>

#include "core/reconstruct/map_grid.h"
#include "core/reconstruct/picture_frame.h"
#include "core/reconstruct/silver_rows.h"
#include "core/reconstruct/tile_renderer.h"
#include "core/screen/screen_map.h"

namespace reseau {

// Renders what lies behind a tile at the sampling of the scan and samples that: bicubic, averaged
// over the pixel where the picture is smaller than the scan. Where nothing is finer than elements,
// a picture of a quarter of the scan's size or less is made of every second or third pixel, unless
// it is to be exact: CIEDE2000 0.03 in the mean. What lies outside the scan is 0. Borrows its
// arguments. Immutable, thread-safe.
class FrameRenderer {
 public:
  FrameRenderer(const TileRenderer& renderer, const PictureFrame& frame, const ScreenMap& map,
                int scan_width_px, int scan_height_px, bool exact)
      : renderer_(renderer),
        frame_(frame),
        map_(map),
        scan_width_px_(scan_width_px),
        scan_height_px_(scan_height_px),
        step_px_(exact || renderer.has_detail() ? 1 : step_for(frame, map)) {}

  // Pixels of the scan from one that is made to the next.
  [[nodiscard]] int step_px() const { return step_px_; }
  // The lines of the scan that a rectangle of the picture needs, without what the tile renderer
  // reaches beyond; empty when the rectangle lies outside the scan.
  [[nodiscard]] PixelBounds scan_rect(const PixelBounds& picture) const;
  // What a rectangle took, in pixels of the scan.
  struct Work {
    std::size_t pixels = 0, blank_pixels = 0;
  };
  // Writes the pixels of the rectangle, [row][pixel][3], `row_stride` floats from row to row.
  Work render(const SilverRows& silver, const PixelBounds& rect, float* out,
              std::ptrdiff_t row_stride) const;

 private:
  static int step_for(const PictureFrame& frame, const ScreenMap& map);

  const TileRenderer& renderer_;
  const PictureFrame& frame_;
  const ScreenMap& map_;
  int scan_width_px_, scan_height_px_, step_px_;
};

}  // namespace reseau
