#pragma once

#include <array>
#include <memory>

#include "drivers/sim/dufay_screen.h"
#include "drivers/sim/film.h"
#include "drivers/sim/film_strip.h"

namespace reseau::sim {

// What the scanner's red, green and blue light sees of a clear element, bare light = 1. Infrared
// passes every element unhindered. [element R G B][channel R G B].
using ElementResponse = std::array<std::array<double, 3>, 3>;

// Measured on a 4000 dpi LS-9000 scan of a Dufaycolor (per unit of infrared), scaled so that the
// largest value is 1; fade 1 makes every element grey at its own mean.
[[nodiscard]] ElementResponse element_response(double fade);

// Silver behind dyed elements: transmittance = silver of that element's colour x its response.
class DufayFilm final : public Film {
 public:
  explicit DufayFilm(const FilmSpec& spec);
  [[nodiscard]] Extent extent() const override { return strip_.extent(); }
  void cells(double y, int first_px, int n_px, int per_px, CellRow& out) const override;

  [[nodiscard]] const FilmStrip& strip() const { return strip_; }
  [[nodiscard]] const DufayScreen& screen() const { return screen_; }
  [[nodiscard]] const ElementResponse& response() const { return response_; }
  // For a perfect scanner; exact, whatever the bend or mirroring.
  [[nodiscard]] ScreenPoint screen_from_scan(double x, double y) const;

 private:
  FilmStrip strip_;
  DufayScreen screen_;
  ElementResponse response_;
};

// Silver only (the luminance of the scene, the same in all bands), as a black-and-white film.
class PlainFilm final : public Film {
 public:
  explicit PlainFilm(const FilmSpec& spec) : strip_(spec) {}
  [[nodiscard]] Extent extent() const override { return strip_.extent(); }
  void cells(double y, int first_px, int n_px, int per_px, CellRow& out) const override;
  [[nodiscard]] const FilmStrip& strip() const { return strip_; }

 private:
  FilmStrip strip_;
};

// Nothing in the light path.
class NoFilm final : public Film {
 public:
  [[nodiscard]] Extent extent() const override;
  void cells(double y, int first_px, int n_px, int per_px, CellRow& out) const override;
};

[[nodiscard]] std::unique_ptr<Film> make_film(const FilmSpec& spec);

}  // namespace reseau::sim
