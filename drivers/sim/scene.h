// What the camera saw: linear exposure of the film in red, green and blue light, 0..1, over the
// picture area of one frame.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "drivers/sim/film_spec.h"

namespace reseau::sim {

// A region of constant exposure; edges inclusive of no transition. Coordinates in optical pixels,
// as the frame's: pixel centres with x0 <= x <= x1, y0 <= y <= y1 see the flat value within any
// blur below the margin the caller leaves.
struct Patch {
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  std::array<double, 3> rgb{};  // linear exposures, = silver transmittance behind each element
};

// Three runs of equal length.
struct RgbRow {
  std::span<float> r, g, b;
};

// A straight border between two colours, through (x, y); coordinates as Patch. The direction of the
// border is (sin angle, cos angle): 0 runs along +y. `left` lies towards -x.
struct Edge {
  double x = 0, y = 0, angle_deg = 0;
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0;  // within this rectangle there is nothing else
  std::array<double, 3> left{}, right{};
};

// Immutable, thread-safe. Coordinates in optical pixels from the corner of the picture; outside the
// picture the scene simply continues.
class Scene {
 public:
  virtual ~Scene() = default;
  // out[i] = exposure of the pixel centred at (x0 + i, y). A smooth scene (no feature narrower than
  // about 3 pixels) may give the value at the centre, a fine one gives the mean over the pixel.
  virtual void row(double y, double x0, const RgbRow& out) const = 0;
  // out[i] = mean exposure over the square of `side_px` (at most 1) centred at
  // (x0 + i * side_px, y). Unless overridden: row(), interpolated linearly.
  virtual void cells(double y, double x0, double side_px, const RgbRow& out) const;
  // The same over tents (CellRow) of that side. Unless overridden: the mean of four cells around.
  virtual void tents(double y, double x0, double side_px, const RgbRow& out) const;
  // True when row() is too coarse for what lies behind an element: then cells() is overridden.
  [[nodiscard]] virtual bool has_fine_detail() const { return false; }
  // Frequency up to which the scene has detail of its own within x0 .. x1 at height y [cycles/px];
  // its cells are means whatever it is, but what an element lets through of them is not.
  [[nodiscard]] virtual double finest_cy_per_px(double /*y*/, double /*x0*/, double /*x1*/) const {
    return 0;
  }
  // True when the values are exposures behind the taking filters already (light that is no mixture
  // of three primaries); otherwise they are the light in red, green and blue.
  [[nodiscard]] virtual bool is_filtered() const { return false; }
  [[nodiscard]] virtual std::vector<Patch> patches() const { return {}; }
  [[nodiscard]] virtual std::vector<Edge> edges() const { return {}; }
};

// A picture of the caller's.
struct SceneRaster {
  int width_px = 0, height_px = 0;
  std::vector<float> rgb;  // [row][pixel][R G B], linear, 1 = white
};

// 24 flat patches in 6 columns and 4 rows, the last row a grey scale, on mid grey. Scales with the
// picture.
[[nodiscard]] std::unique_ptr<Scene> make_chart_scene(double width_px, double height_px);

// Sky with clouds, wooded hills, lawn, figures with skin and dyed cloth, a fence for fine detail.
[[nodiscard]] std::unique_ptr<Scene> make_natural_scene(double width_px, double height_px,
                                                        std::uint64_t seed);

// Light of one wavelength at every place, 400 nm at the left to 700 nm at the right, seen through
// the taking filters of Harrison and Horner 1939; the exposure falls by 1.5 decades from top to
// bottom. Gives exposures behind the elements.
[[nodiscard]] std::unique_ptr<Scene> make_sweep_scene(double width_px, double height_px);

// Six fields in 3 x 2, each with one border between two colours, slanted by angle_deg: black and
// white, red and green, green and blue / blue and red, grey and orange, cyan and red. A step, exact
// for any size of cell.
[[nodiscard]] std::unique_ptr<Scene> make_edges_scene(double width_px, double height_px,
                                                      double angle_deg);

// Square blades, one for about 900 px of the frame, turned by angle_deg: slanted edges of both
// directions all over the field, 0.02 behind a blade, 1 beside it.
[[nodiscard]] std::unique_ptr<Scene> make_razor_scene(double width_px, double height_px,
                                                      double angle_deg);

// 1024 by 1024 square cells in the middle, clear or opaque by chance, turned by angle_deg; opaque
// around. calibration/random/random_cells.h says which.
[[nodiscard]] std::unique_ptr<Scene> make_random_scene(double width_px, double height_px,
                                                       std::uint64_t seed, double cell_px,
                                                       double angle_deg);

// Nothing in the light path.
[[nodiscard]] std::unique_ptr<Scene> make_clear_scene();

// Neutral, 0.5 + 0.45 cos(pi f r^2 / R): the frequency grows linearly with the distance r from the
// centre and is finest_cy_per_px at R, half the smaller side.
[[nodiscard]] std::unique_ptr<Scene> make_zone_scene(double width_px, double height_px,
                                                     double finest_cy_per_px);

// Neutral sinusoidal star, 0.5 + 0.45 cos(spokes * angle), around an even disc where the spokes
// would be finer than 1.5 cycles per px.
[[nodiscard]] std::unique_ptr<Scene> make_star_scene(double width_px, double height_px, int spokes);

// The raster, scaled to cover the picture and cropped evenly on both sides. Between the centres of
// its pixels it is bilinear; a cell gets the exact mean of that over its area, however fine the
// raster is. Throws InputError when the raster is empty, of the wrong size or not finite.
[[nodiscard]] std::unique_ptr<Scene> make_image_scene(std::shared_ptr<const SceneRaster> raster,
                                                      double width_px, double height_px);

}  // namespace reseau::sim
