// A small Dufaycolor scan with a known truth for the tests of core: painted by supersampling, with
// code of its own that shares nothing with what is under test.
#pragma once

#include <array>
#include <cstdint>
#include <functional>

#include "core/line/memory_line_source.h"

namespace reseau::test {

struct SyntheticScan {
  int width_px = 600;
  int height_px = 600;
  double period_u_px = 7.82;  // along the red lines
  double period_v_px = 7.71;  // across them
  double angle_deg = 22.8;    // of the red lines from the y axis
  double axes_deg = 88.9;     // between the two printings
  bool mirrored = false;      // the scan flipped left to right
  double phase_u = 0.31, phase_v = 0.77;
  double blur_px = 0.6;  // sigma of R, G, B, pixel integral not included
  double ir_blur_px = 0.6;
  double noise = 0.003;   // of full scale, one sigma
  double exposure = 0.9;  // infrared of clear film
  double fade = 0;        // 0 fresh dyes .. 1 grey
  bool infrared = true;
  std::uint64_t seed = 1;
  // Scan displacement [px] at a scan position; smooth.
  std::function<std::array<double, 2>(double, double)> displacement_px;
  // Scene: element intensities (R, G, B) at a scan position, 0..1. Default: a neutral 0.6.
  std::function<std::array<double, 3>(double, double)> scene;

  // Screen coordinates of a scan position: origin at a green centre, red lines at v = 0.5.
  [[nodiscard]] std::array<double, 2> screen_from_scan(double x, double y) const;
  [[nodiscard]] MemoryLineSource render() const;
  // Scanner response to the clear elements, [element][channel], per unit infrared.
  [[nodiscard]] std::array<std::array<double, 3>, 3> response() const;
};

}  // namespace reseau::test
