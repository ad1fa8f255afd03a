// Screens as data: a lattice and, in the order of painting, shapes of one dye each on a ground.
// Written from published geometry; shares nothing with the reconstruction.
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "drivers/sim/film/film_point.h"
#include "drivers/sim/film_spec.h"

namespace reseau::sim {

// |n_u u + n_v v| < half, in periods, (u, v) from the shape's centre. A line has one band with
// whole n, and repeats with it; a polygon is what two or more bands have in common.
struct ShapeBand {
  double n_u = 0, n_v = 0, half = 0;
};

// Polygons and discs repeat once per cell of the lattice.
struct ScreenShape {
  enum class Kind { kLine, kPolygon, kDisc };
  Kind kind = Kind::kLine;
  int dye = 0;  // 0 red, 1 green, 2 blue
  double u = 0, v = 0;
  std::vector<ShapeBand> bands;
  double radius = 0;  // of a disc [period_u]
  // Printed across what was painted before, as the last lines of a Dufaycolor; otherwise it lies
  // beside the other shapes, on the ground, and may touch them.
  bool across = false;
};

struct ScreenDescription {
  std::string_view name;
  int ground = 2;  // dye of what no shape covers
  std::vector<ScreenShape> shapes;
  std::array<double, 3> areas{};         // fractions of red, green, blue; closed form of the layout
  std::array<ScreenPoint, 3> middles{};  // of one red, green and blue element of a period
};

// The layout of a kind; for screens of lines and squares with the fractions of the spec. Sources
// are given in FILM.md.
[[nodiscard]] ScreenDescription describe_screen(const ScreenSpec& spec);

}  // namespace reseau::sim
