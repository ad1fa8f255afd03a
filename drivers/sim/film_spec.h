// Parameters of the simulated film. Plain values; sim_spec.h parses and checks them.
#pragma once

#include <cstdint>

namespace reseau::sim {

enum class FilmKind { kDufay, kPlain, kEmpty };  // with réseau, silver only, no film at all
enum class SceneKind { kChart, kNatural };

// Area of one frame in optical pixels; a strip repeats it along y.
struct FrameSpec {
  int width_px = 3946;
  int height_px = 5959;
  int n_frames = 1;
  double pixel_um = 25400.0 / 4000.0;
  // From the edge of the frame inwards: clear rebate, then dark border, then the picture.
  double rebate_px = 0;
  double border_px = 12;
};

// Element geometry: micrograph of Dufaycolor, Hubicka et al. 2025 (arXiv:2501.06216): red lines
// 21.0 of 49.9 um, green 22.7 of 49.6 um along the lines, blue the rest.
struct ScreenSpec {
  double period_u_um = 49.6;  // along the red lines, green to green
  double period_v_um = 49.9;  // from red line to red line, along the other axis
  double angle_deg = 23.0;    // of the red lines, from +y towards +x
  double axes_deg = 89.4;     // between the two lattice directions
  double phase_u = 0.3;       // screen coordinates of scan position (0, 0) [periods]
  double phase_v = 0.1;
  double red_fraction = 21.0 / 49.9;    // of a period, across
  double green_fraction = 22.7 / 49.6;  // of a period, along
  double bend_px = 0;                   // largest smooth displacement of the réseau, per axis
};

struct FilmSpec {
  FilmKind kind = FilmKind::kDufay;
  SceneKind scene = SceneKind::kChart;
  FrameSpec frame;
  ScreenSpec screen;
  bool mirrored = false;  // film laid in emulsion side the other way
  double fade = 0;        // 0 fresh dyes .. 1 grey elements
  std::uint64_t seed = 1;
};

}  // namespace reseau::sim
