// Least squares for the line of an edge and the levels beside it, on the pixels. See
// measure_edge.h.
#pragma once

#include <functional>
#include <vector>

#include "calibration/edge/edge_line.h"
#include "core/base/span2d.h"

namespace reseau {

// Levels on the dark and the bright side, and how they change along (per half length) and across
// (per reach).
struct EdgeLevels {
  double dark = 0, bright = 1;
  double dark_along = 0, bright_along = 0;
  double dark_across = 0, bright_across = 0;
};

struct PixelModel {
  EdgeLine line;
  EdgeLevels levels;
  double reach_px = 30;  // farther pixels are left out
};

// One pixel near the edge.
struct EdgePixel {
  double distance = 0, along = 0, value = 0;
  int x = 0, y = 0;
};

// Pixels within the reach of the line, row by row. `used` (row by row, may be empty) tells which
// may be used.
void for_each_edge_pixel(Span2D<const float> samples, std::span<const unsigned char> used,
                         const PixelModel& model,
                         const std::function<void(std::span<const EdgePixel>)>& row);

struct ProfilePoint {
  double value = 0, slope = 0, by_width = 0;
};
using ProfileFunction = std::function<void(std::span<const EdgePixel>, std::span<ProfilePoint>)>;

struct PixelStep {
  PixelModel model;
  double width_step = 0;  // of the parameter `by_width`
  double moved_px = 0;    // how far the line moved, at most
  double rms = 0;         // of the residuals before the step
  double n = 0;
  double bend_sd = 0, twist_sd = 0;
  bool ok = false;
};

// One step of Gauss and Newton. n_shape: 0 straight, 1 with bend, 2 with twist.
[[nodiscard]] PixelStep pixel_step(Span2D<const float> samples, std::span<const unsigned char> used,
                                   const PixelModel& model, const ProfileFunction& profile,
                                   int n_shape, bool with_width, bool with_along);

}  // namespace reseau
