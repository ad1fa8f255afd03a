// Finds the frames of a strip on its thumbnail. Pure, reentrant.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace reseau::coolscan {

struct Overview {
  std::span<const std::uint16_t> samples;  // [line][red, green, blue][pixel]
  int width_px = 0, n_lines = 0;
};

struct FoundFrame {
  double top_line = 0;  // where the frame's raster begins, half a gap above the picture
  bool on_the_film =
      false;  // a gap was seen there; otherwise the place follows from its neighbours
};

// frame_lines: from frame to frame by the adapter's raster. n_frames: how many the unit counted.
// A gap between two frames is a line that is even across the film where its surroundings are not;
// each frame may lie up to a tenth of its length off the raster, whatever the others do. Empty when
// there is no contrast at all.
[[nodiscard]] std::vector<FoundFrame> find_frames(const Overview& overview, double frame_lines,
                                                  int n_frames);

}  // namespace reseau::coolscan
