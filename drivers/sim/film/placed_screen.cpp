#include "drivers/sim/film/placed_screen.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace reseau::sim {
namespace {}  // namespace

PlacedScreen::PlacedScreen(const FilmSpec& spec)
    : spec_(spec.screen),
      deform_(spec.deform),
      mirrored_(spec.mirrored),
      last_x_(spec.frame.width_px - 1),
      centre_x_((spec.frame.width_px - 1) / 2.0),
      centre_y_((spec.frame.height_px - 1) / 2.0),
      half_width_(spec.frame.width_px / 2.0),
      half_height_(spec.frame.height_px / 2.0),
      wave_x_(2 * std::numbers::pi / spec.frame.width_px),
      wave_y_(2 * std::numbers::pi / spec.frame.height_px),
      curl_px_(spec.deform.curl_um / spec.frame.pixel_um) {
  // Lattice vectors [px]: one green to the next along a red line, one red line to the next.
  const double along = spec_.angle_deg * std::numbers::pi / 180;
  const double across = (spec_.angle_deg - spec_.axes_deg) * std::numbers::pi / 180;
  const double length_u = spec_.period_u_um / spec.frame.pixel_um;
  const double length_v = spec_.period_v_um / spec.frame.pixel_um;
  const FilmPoint a{length_u * std::sin(along), length_u * std::cos(along)};
  const FilmPoint b{length_v * std::sin(across), length_v * std::cos(across)};
  const double det = a.x * b.y - b.x * a.y;
  gradient_ = {b.y / det, -b.x / det, -a.y / det, a.x / det};
}

FilmPoint PlacedScreen::waves(FilmPoint p, double radian_per_px_x, double radian_per_px_y) const {
  const double fx = p.x * radian_per_px_x, fy = p.y * radian_per_px_y;
  return {0.6 * std::sin(0.7 * fx + 0.3 * fy + 0.5) + 0.4 * std::sin(0.4 * fx - 0.9 * fy + 2.1),
          0.6 * std::sin(-0.5 * fx + 0.8 * fy + 1.2) + 0.4 * std::sin(0.9 * fx + 0.5 * fy + 4.0)};
}

// Curl, perspective and radial displacement; the film's own place of what the scanner sees at p.
FilmPoint PlacedScreen::projected(FilmPoint p) const {
  double x = p.x - centre_x_, y = p.y - centre_y_;
  if (curl_px_ != 0) {
    // Seen from straight above, the film between the middle and x is as long as the arc of the
    // parabola curl (x / half_width)^2.
    const double slope = 2 * curl_px_ / (half_width_ * half_width_);
    const double s = slope * x;
    x = (x * std::sqrt(1 + s * s) + std::asinh(s) / slope) / 2;
  }
  if (deform_.perspective_x != 0 || deform_.perspective_y != 0) {
    const double scale = 1 / (1 + deform_.perspective_x * x / half_width_ +
                              deform_.perspective_y * y / half_height_);
    x *= scale;
    y *= scale;
  }
  if (deform_.radial != 0) {
    const double corner2 = half_width_ * half_width_ + half_height_ * half_height_;
    const double scale = 1 + deform_.radial * (x * x + y * y) / corner2;
    x *= scale;
    y *= scale;
  }
  return {centre_x_ + x, centre_y_ + y};
}

ScreenPoint PlacedScreen::screen_from_film(FilmPoint p) const {
  const bool project = curl_px_ != 0 || deform_.perspective_x != 0 || deform_.perspective_y != 0 ||
                       deform_.radial != 0;
  const FilmPoint at = p;
  if (project) p = projected(p);
  if (spec_.bend_px != 0) {
    const FilmPoint d = waves(at, wave_x_, wave_y_);
    p = {p.x + spec_.bend_px * d.x, p.y + spec_.bend_px * d.y};
  }
  if (deform_.warp_px != 0) {
    const double radian_per_px = 2 * std::numbers::pi / deform_.warp_length_px;
    p.x += deform_.warp_px * std::sin(radian_per_px * (0.8 * at.x + 0.6 * at.y));
    p.y += deform_.warp_px * std::cos(radian_per_px * (-0.6 * at.x + 0.8 * at.y));
  }
  return {gradient_.u_x * p.x + gradient_.u_y * p.y + spec_.phase_u,
          gradient_.v_x * p.x + gradient_.v_y * p.y + spec_.phase_v};
}

ScreenGradient PlacedScreen::scan_gradient() const {
  ScreenGradient g = gradient_;
  if (mirrored_) {
    g.u_x = -g.u_x;
    g.v_x = -g.v_x;
  }
  return g;
}

double PlacedScreen::height_um(double x) const {
  const double film_x = mirrored_ ? last_x_ - x : x;
  const double t = (film_x - centre_x_) / half_width_;
  return deform_.curl_um * t * t;
}

double PlacedScreen::largest_curvature() const {
  const double bend = 0.97 * std::max(wave_x_, wave_y_);  // 0.4 and 0.9 in quadrature
  const double warp = 2 * std::numbers::pi / deform_.warp_length_px;
  const double smaller = std::min(half_width_, half_height_);
  const double perspective =
      4 * (std::abs(deform_.perspective_x) + std::abs(deform_.perspective_y)) / smaller;
  const double slope = 2 * curl_px_ / (half_width_ * half_width_);
  return std::abs(spec_.bend_px) * bend * bend + std::abs(deform_.warp_px) * warp * warp +
         perspective + 6 * std::abs(deform_.radial) / smaller + slope * slope * half_width_;
}

double PlacedScreen::largest_strain() const {
  const double bend = 0.97 * std::max(wave_x_, wave_y_);
  const double warp = 2 * std::numbers::pi / deform_.warp_length_px;
  return std::abs(spec_.bend_px) * bend + std::abs(deform_.warp_px) * warp +
         2 * (std::abs(deform_.perspective_x) + std::abs(deform_.perspective_y)) +
         3 * std::abs(deform_.radial) + std::hypot(1.0, 2 * curl_px_ / half_width_) - 1;
}

}  // namespace reseau::sim
