// The silver of the film: one or more frames behind each other, each with its picture, border and
// rebate.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "drivers/sim/film.h"
#include "drivers/sim/film_spec.h"
#include "drivers/sim/scene.h"

namespace reseau::sim {

struct FilmPoint {
  double x = 0, y = 0;
};

// Immutable, thread-safe.
class FilmStrip {
 public:
  explicit FilmStrip(const FilmSpec& spec);

  // Where on the film a perfect scanner looks at scan position (x, y): mirroring undone.
  [[nodiscard]] FilmPoint film_from_scan(double x, double y) const;
  // Transmittance of the silver behind a red, green and blue element at scan positions (x0 + i, y).
  // Beyond the ends of the film it is 1; see on_film().
  void silver_row(double y, double x0, const RgbRow& out) const;
  [[nodiscard]] std::array<double, 3> silver_at(double x, double y) const;
  // False where the strip has ended and the sensor sees bare light.
  [[nodiscard]] bool on_film(double y) const;
  // Along the sensor: the frames and a margin that no window at rest on a frame reaches.
  [[nodiscard]] Film::Extent extent() const;
  // In scan coordinates, all frames.
  [[nodiscard]] std::vector<Patch> patches() const;

  [[nodiscard]] const FilmSpec& spec() const { return spec_; }

 private:
  [[nodiscard]] int frame_at(double film_y) const;
  void silver_in_film(double film_y, double film_x0, const RgbRow& out) const;
  void apply_frame(double local_y, double film_x0, const RgbRow& out) const;

  FilmSpec spec_;
  double margin_px_;                            // from the edge of a frame to its picture
  std::vector<std::unique_ptr<Scene>> scenes_;  // one per frame, or one for all
};

}  // namespace reseau::sim
