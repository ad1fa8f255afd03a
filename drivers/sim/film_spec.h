// Parameters of the simulated film. Plain values; sim_spec.h parses and checks them.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "core/screen/screen_description.h"
#include "drivers/sim/film/element_response.h"
#include "drivers/sim/film/hd_curve.h"

namespace reseau::sim {

struct SceneRaster;

// With réseau, silver only, no film at all.
enum class FilmKind { kDufay, kPlain, kEmpty };
enum class SceneKind {
  kChart,
  kNatural,
  kSweep,
  kEdges,
  kZone,
  kStar,
  kImage,
  kRazor,
  kClear,
  kRandom
};

// Area of one frame in optical pixels; a strip repeats it along y.
struct FrameSpec {
  int width_px = 3946;
  int height_px = 5959;
  int n_frames = 1;
  double pixel_um = 25400.0 / 4000.0;
  // From the sides of the frame inwards: bare light beside the film, then from all edges clear
  // rebate, then dark border, then the picture.
  double outside_px = 0;
  double rebate_px = 0;
  double border_px = 12;
};

// Element geometry: micrograph of Dufaycolor, Hubicka et al. 2025 (arXiv:2501.06216): red lines
// 21.0 of 49.9 um, green 22.7 of 49.6 um along the lines, blue the rest.
struct ScreenSpec {
  ScreenKind kind = ScreenKind::kDufaycolor;
  double period_u_um = 49.6;  // along the red lines, green to green
  double period_v_um = 49.9;  // from red line to red line, along the other axis
  double angle_deg = 23.0;    // of the red lines, from +y towards +x
  double axes_deg = 89.4;     // between the two lattice directions
  double phase_u = 0.3;       // screen coordinates of scan position (0, 0) [periods]
  double phase_v = 0.1;
  double red_fraction = 21.0 / 49.9;    // of a period, across: the line
  double green_fraction = 22.7 / 49.6;  // of a period, along: the first kind of square
  double bend_px = 0;                   // largest smooth displacement of the réseau, per axis
};

// Deformation of the réseau besides its bend. The origin is the centre of the first frame, where
// the mean geometry stays that of ScreenSpec.
struct DeformSpec {
  double perspective_x = 0, perspective_y = 0;  // change of scale from centre to edge
  double radial = 0;                            // relative displacement in the corner of the frame
  double warp_px = 0;                           // amplitude of a shorter wave in both axes
  double warp_length_px = 700;                  // its length
  double curl_um = 0;                           // height of the sides above the middle
};

// Errors of the printing press.
struct PrintSpec {
  double overlap_um = 0;   // of neighbouring elements; negative: a gap between them
  bool dark_gaps = false;  // a gap lets no light through instead of all
  double position_noise_um = 0, width_noise_um = 0;  // rms, of a line (or of an element)
  double noise_length_um = 200;                      // over which a line's errors change
  double missing = 0;                                // fraction of lines (or elements) left out
};

struct EmulsionSpec {
  bool ideal_taking = true;  // elements pass their own third of the light only
  HdSpec hd;
  double spread_um = 0;         // Gaussian spread of the light in the emulsion
  double silver_spread_um = 0;  // of the developed silver
  // Relative rms of the transmittance of a square pixel of the film at density 1; it grows with the
  // root of the density.
  double grain = 0;
  double grain_um = 2.5;  // size of the grain: spacing of the field's knots
};

// Harm that came later.
struct DamageSpec {
  double dust_per_cm2 = 0, dust_um = 40;       // mean radius
  double scratches_per_cm = 0;                 // of the width of the film
  double bubbles_per_cm2 = 0, bubble_um = 90;  // mean radius
  double faded_areas = 0;                      // how far the worst places are faded, 0..1
  double stains = 0;                           // 0..1, depth of the darkest stain in blue light
};

struct FilmSpec {
  FilmKind kind = FilmKind::kDufay;
  SceneKind scene = SceneKind::kChart;
  std::shared_ptr<const SceneRaster> raster;  // kImage
  std::string picture;                        // the file it was read from, if it was one
  double edge_angle_deg = 5;                  // kEdges, kRazor, kRandom
  double random_cell_um = 3.2;                // kRandom
  double finest_cy_per_px = 0.5;              // kZone
  int spokes = 72;                            // kStar
  FrameSpec frame;
  ScreenSpec screen;
  DeformSpec deform;
  PrintSpec print;
  EmulsionSpec emulsion;
  DyeSpec dyes;
  DamageSpec damage;
  bool mirrored = false;  // film laid in emulsion side the other way
  std::uint64_t seed = 1;
  // Every film by the general path, also one that the fast one can render.
  bool general_path = false;
};

}  // namespace reseau::sim
