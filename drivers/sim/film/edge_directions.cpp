#include "drivers/sim/film/edge_directions.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/sim/film/placed_screen.h"
#include "drivers/sim/film/screen_of.h"

namespace reseau::sim {
namespace {

double off_axes_deg(double angle_deg) {
  const double rest = std::abs(std::remainder(angle_deg, 90.0));
  return std::min(rest, 90 - rest);
}

}  // namespace

double edges_off_axes_deg(const FilmSpec& spec) {
  double least = Film::kNoEdgesDeg;
  if (spec.kind == FilmKind::kEmpty) return least;
  if (spec.scene == SceneKind::kEdges) least = off_axes_deg(spec.edge_angle_deg);
  if (spec.kind != FilmKind::kDufay) return least;
  const ScreenGradient g = PlacedScreen(spec).scan_gradient();
  for (const ScreenShape& shape : describe_screen(spec.screen).shapes) {
    for (const ScreenBand& band : shape.bands) {
      const double x = band.n.x * g.u_x + band.n.y * g.v_x;
      const double y = band.n.x * g.u_y + band.n.y * g.v_y;
      least = std::min(least, off_axes_deg(std::atan2(y, x) * 180 / std::numbers::pi));
    }
  }
  return least;
}

}  // namespace reseau::sim
