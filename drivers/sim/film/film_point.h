#pragma once

namespace reseau::sim {

// Optical pixels on the film.
struct FilmPoint {
  double x = 0, y = 0;
};

// Periods along the two directions of the réseau, not reduced to one period. For screens of lines
// with squares between (Dufaycolor): u along the lines, v across; (0, 0) is the centre of the first
// kind of square, (0.5, 0) of the second, lines lie at v = 0.5.
struct ScreenPoint {
  double u = 0, v = 0;
};

// Derivative of (u, v) by (x, y) [periods/px].
struct ScreenGradient {
  double u_x = 0, u_y = 0, v_x = 0, v_y = 0;
};

}  // namespace reseau::sim
