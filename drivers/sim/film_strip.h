// The silver of the film: one or more frames behind each other, each with its picture, border and
// rebate.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "drivers/sim/film.h"
#include "drivers/sim/film/film_point.h"
#include "drivers/sim/film/hd_curve.h"
#include "drivers/sim/film_spec.h"
#include "drivers/sim/scene.h"

namespace reseau::sim {

// Immutable, thread-safe.
class FilmStrip {
 public:
  // Throws InputError for a picture of the caller's that cannot be used.
  explicit FilmStrip(const FilmSpec& spec);

  // Where on the film a perfect scanner looks at scan position (x, y): mirroring undone.
  [[nodiscard]] FilmPoint film_from_scan(double x, double y) const;
  // Transmittance of the silver behind a red, green and blue element at scan positions (x0 + i, y).
  // Beyond the ends of the film it is 1; see on_film().
  void silver_row(double y, double x0, const RgbRow& out) const;
  [[nodiscard]] std::array<double, 3> silver_at(double x, double y) const;
  // Exposure behind red, green and blue elements, mean over the squares of `side_px` (at most 1)
  // centred at scan positions (x0 + i * side_px, y). Rebate and border are exposures too. tents:
  // over those (CellRow).
  void exposure_cells(double y, double x0, double side_px, const RgbRow& out,
                      bool tents = false) const;
  [[nodiscard]] const HdCurve& hd_curve() const { return hd_; }
  // True when pixels are too coarse for the scene: silver_row() then gives means over pixels.
  [[nodiscard]] bool has_fine_detail() const { return scenes_.front()->has_fine_detail(); }
  // True when the scene has steps, which cells of any size have within them.
  [[nodiscard]] bool has_steps() const {
    return spec_.scene == SceneKind::kEdges || spec_.scene == SceneKind::kRazor ||
           spec_.scene == SceneKind::kRandom;
  }
  // Whether the soft ends of border and rebate are near a place of a row between x0 and x1.
  [[nodiscard]] bool near_frame(double y, double x0, double x1) const;
  // Of a scene that cells of 1 / kWholeCellsAt px hold as they are; of half the side, twice as fine
  // ones [cycles/px].
  static constexpr double kWholeCells = 0.54;
  static constexpr int kWholeCellsAt = 8;
  // Up to which the scene has detail between two places of a row [cycles/px].
  [[nodiscard]] double finest_cy_per_px(double y, double x0, double x1) const;
  // False where the strip has ended and the sensor sees bare light.
  [[nodiscard]] bool on_film(double y) const;
  // Along the sensor: the frames and a margin that no window at rest on a frame reaches.
  [[nodiscard]] Film::Extent extent() const;
  // In scan coordinates, all frames.
  [[nodiscard]] std::vector<Patch> patches() const;
  [[nodiscard]] std::vector<Edge> edges() const;

  [[nodiscard]] const FilmSpec& spec() const { return spec_; }

 private:
  [[nodiscard]] int frame_at(double film_y) const;
  // side_px 0: a row of pixels by Scene::row().
  void exposure_in_film(double film_y, double film_x0, double side_px, bool tents,
                        const RgbRow& out) const;
  void apply_taking(const RgbRow& out) const;
  void apply_frame(double local_y, double film_x0, double side_px, bool tents,
                   const RgbRow& out) const;
  [[nodiscard]] std::array<double, 3> silver_of(const std::array<double, 3>& light) const;
  void exposure(double y, double x0, double side_px, bool tents, const RgbRow& out) const;

  FilmSpec spec_;
  Taking taking_;
  HdCurve hd_;
  double margin_px_;                            // from the edge of a frame to its picture
  std::vector<std::unique_ptr<Scene>> scenes_;  // one per frame, or one for all
};

}  // namespace reseau::sim
