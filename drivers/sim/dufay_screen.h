// Where the elements of the réseau lie on the scan. Written from the geometry alone; shares nothing
// with the reconstruction.
#pragma once

#include <array>

#include "drivers/sim/film_spec.h"
#include "drivers/sim/film_strip.h"

namespace reseau::sim {

// Periods: u along the red lines, v across. (0, 0) is the centre of a green element, (0.5, 0) of a
// blue one, red lines lie at v = 0.5. Not reduced to one period.
struct ScreenPoint {
  double u = 0, v = 0;
};

// Derivative of (u, v) by (x, y) [periods/px].
struct ScreenGradient {
  double u_x = 0, u_y = 0, v_x = 0, v_y = 0;
};

// Immutable, thread-safe.
class DufayScreen {
 public:
  DufayScreen(const ScreenSpec& spec, const FrameSpec& frame);

  [[nodiscard]] ScreenPoint screen_from_film(FilmPoint p) const;
  // Without the bend, in film coordinates.
  [[nodiscard]] const ScreenGradient& gradient() const { return gradient_; }
  // Fractions of the area of red, green and blue elements.
  [[nodiscard]] std::array<double, 3> area_fractions() const;
  [[nodiscard]] const ScreenSpec& spec() const { return spec_; }

 private:
  [[nodiscard]] FilmPoint bend(FilmPoint p) const;
  ScreenSpec spec_;
  ScreenGradient gradient_;
  double wave_x_, wave_y_;  // radians per pixel: one wave over the frame
};

}  // namespace reseau::sim
