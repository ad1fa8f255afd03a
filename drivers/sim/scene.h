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

// Smooth on the scale of a pixel (no feature narrower than about 3 optical pixels), so that linear
// interpolation between pixels is harmless. Immutable, thread-safe.
class Scene {
 public:
  virtual ~Scene() = default;
  // out[i] = exposure at (x0 + i, y); coordinates from the corner of the picture. Outside the
  // picture the scene simply continues.
  virtual void row(double y, double x0, const RgbRow& out) const = 0;
  [[nodiscard]] virtual std::vector<Patch> patches() const { return {}; }
};

// 24 flat patches in 6 columns and 4 rows, the last row a grey scale, on mid grey. Scales with the
// picture.
[[nodiscard]] std::unique_ptr<Scene> make_chart_scene(double width_px, double height_px);

// Sky with clouds, wooded hills, lawn, figures with skin and dyed cloth, a fence for fine detail.
[[nodiscard]] std::unique_ptr<Scene> make_natural_scene(double width_px, double height_px,
                                                        std::uint64_t seed);

}  // namespace reseau::sim
