// Where the elements of the réseau lie on the scan: lattice and deformation in closed form.
#pragma once

#include "drivers/sim/film/film_point.h"
#include "drivers/sim/film_spec.h"

namespace reseau::sim {

// Immutable, thread-safe.
class PlacedScreen {
 public:
  explicit PlacedScreen(const FilmSpec& spec);

  // For a perfect scanner; exact, whatever the deformation or mirroring.
  [[nodiscard]] ScreenPoint screen_from_scan(double x, double y) const {
    return screen_from_film({mirrored_ ? last_x_ - x : x, y});
  }
  [[nodiscard]] ScreenPoint screen_from_film(FilmPoint p) const;
  // The mean geometry, in film coordinates: without the deformation.
  [[nodiscard]] const ScreenGradient& gradient() const { return gradient_; }
  // The same by scan coordinates: mirroring turns its x.
  [[nodiscard]] ScreenGradient scan_gradient() const;
  [[nodiscard]] const ScreenSpec& spec() const { return spec_; }
  // Height of the film above the plane of best focus [um].
  [[nodiscard]] double height_um(double x) const;
  // No second derivative of the deformation exceeds this [1/px].
  [[nodiscard]] double largest_curvature() const;
  // No first derivative of the deformation exceeds this.
  [[nodiscard]] double largest_strain() const;

 private:
  [[nodiscard]] FilmPoint waves(FilmPoint p, double radian_per_px_x, double radian_per_px_y) const;
  [[nodiscard]] FilmPoint projected(FilmPoint p) const;
  ScreenSpec spec_;
  DeformSpec deform_;
  ScreenGradient gradient_;
  bool mirrored_;
  double last_x_;                    // of the frame
  double centre_x_, centre_y_;       // of the first frame
  double half_width_, half_height_;  // of a frame
  double wave_x_, wave_y_;           // radians per pixel: one wave over the frame
  double curl_px_;                   // height of the sides
};

}  // namespace reseau::sim
