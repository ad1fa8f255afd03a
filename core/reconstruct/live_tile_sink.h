// Where the provisional picture of a running scan goes.
#pragma once

#include <span>

namespace reseau {

// A part of the provisional picture, at the geometry of the scan. The rectangles of a picture do
// not overlap and come from top to bottom.
struct LiveTile {
  int x_px = 0, y_px = 0, width_px = 0, height_px = 0;
  // Scene-linear, [row][pixel][3 channels], width_px x height_px; lent until tile() returns.
  std::span<const float> rgb;
  // The map that it was made with holds in so many lines: a number that grows from map to map.
  int map_lines = 0;
  // Of the lines that were committed when the tile was finished.
  int committed_lines = 0;
};

// Calls come from one thread, which is neither the scanner's nor the writer's nor the one that
// makes the final picture: a sink may take its time. While it does, lines pile up and come as
// fewer, higher tiles, and what has not come when the final picture begins never does. It must
// return at last; what it throws ends the provisional picture and nothing else.
class LiveTileSink {
 public:
  virtual ~LiveTileSink() = default;
  // Of the scan; once, before the first tile.
  virtual void begin(int width_px, int height_px) = 0;
  virtual void tile(const LiveTile& tile) = 0;
};

}  // namespace reseau
