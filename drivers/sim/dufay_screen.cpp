#include "drivers/sim/dufay_screen.h"

#include <cmath>

namespace reseau::sim {
namespace {
constexpr double kPi = 3.14159265358979323846;
}  // namespace

DufayScreen::DufayScreen(const ScreenSpec& spec, const FrameSpec& frame)
    : spec_(spec), wave_x_(2 * kPi / frame.width_px), wave_y_(2 * kPi / frame.height_px) {
  // Lattice vectors [px]: one green to the next along a red line, one red line to the next.
  const double along = spec.angle_deg * kPi / 180;
  const double across = (spec.angle_deg - spec.axes_deg) * kPi / 180;
  const double length_u = spec.period_u_um / frame.pixel_um;
  const double length_v = spec.period_v_um / frame.pixel_um;
  const FilmPoint a{length_u * std::sin(along), length_u * std::cos(along)};
  const FilmPoint b{length_v * std::sin(across), length_v * std::cos(across)};
  const double det = a.x * b.y - b.x * a.y;
  gradient_ = {b.y / det, -b.x / det, -a.y / det, a.x / det};
}

FilmPoint DufayScreen::bend(FilmPoint p) const {
  const double fx = p.x * wave_x_, fy = p.y * wave_y_;
  return {0.6 * std::sin(0.7 * fx + 0.3 * fy + 0.5) + 0.4 * std::sin(0.4 * fx - 0.9 * fy + 2.1),
          0.6 * std::sin(-0.5 * fx + 0.8 * fy + 1.2) + 0.4 * std::sin(0.9 * fx + 0.5 * fy + 4.0)};
}

ScreenPoint DufayScreen::screen_from_film(FilmPoint p) const {
  if (spec_.bend_px != 0) {
    const FilmPoint d = bend(p);
    p = {p.x + spec_.bend_px * d.x, p.y + spec_.bend_px * d.y};
  }
  return {gradient_.u_x * p.x + gradient_.u_y * p.y + spec_.phase_u,
          gradient_.v_x * p.x + gradient_.v_y * p.y + spec_.phase_v};
}

std::array<double, 3> DufayScreen::area_fractions() const {
  const double red = spec_.red_fraction;
  const double green = (1 - red) * spec_.green_fraction;
  return {red, green, 1 - red - green};
}

}  // namespace reseau::sim
