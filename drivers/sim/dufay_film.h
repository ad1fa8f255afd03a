#pragma once

#include <cstdint>

#include "drivers/sim/film.h"
#include "drivers/sim/film/placed_screen.h"
#include "drivers/sim/film_strip.h"

namespace reseau::sim {

// Silver behind dyed elements: transmittance = silver of that element's colour x its response, and
// what both change together within a cell (FILM.md 3). The fast path for a Dufaycolor without the
// nuisances of ScreenFilm, which renders any film.
class DufayFilm final : public Film {
 public:
  explicit DufayFilm(const FilmSpec& spec);
  [[nodiscard]] Extent extent() const override { return strip_.extent(); }
  [[nodiscard]] Edges edges() const override { return edges_; }
  void cells(double y, int first_px, int n_px, int per_px, CellRow& out) const override;

  [[nodiscard]] double height_um(double x, double /*y*/) const override {
    return screen_.height_um(x);
  }
  // Whether this path renders the film: a Dufaycolor, nothing finer than a pixel but the réseau,
  // nothing that bends it within a block of pixels, no harm.
  [[nodiscard]] static bool can_render(const FilmSpec& spec);

 private:
  FilmStrip strip_;
  PlacedScreen screen_;
  ElementResponse response_;
  Edges edges_;
  bool strained_;     // so much that edges change their direction within the frame
  std::uint64_t id_;  // of this film among all that ever were
};

}  // namespace reseau::sim
