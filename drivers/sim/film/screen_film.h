// Any film: every screen, every nuisance.
#pragma once

#include <cstdint>
#include <memory>

#include "drivers/sim/film.h"
#include "drivers/sim/film/damage.h"
#include "drivers/sim/film/element_painter.h"
#include "drivers/sim/film/element_response.h"
#include "drivers/sim/film/grain.h"
#include "drivers/sim/film/light_rows.h"
#include "drivers/sim/film/silver_layer.h"
#include "drivers/sim/film_strip.h"

namespace reseau::sim {

// Transmittance of a cell = sum over the sets of dyes of their area x silver behind them, with its
// grain and harm and with what area and silver change together, x what the light of the channel
// sees of the dyes; then stains and the edge of the film. Where the scene is finer than cells can
// hold they are divided further. Without a réseau (FilmKind::kPlain) silver only, the same in all
// bands. FILM.md derives the model.
class ScreenFilm final : public Film {
 public:
  // kind is kDufay (whatever the screen) or kPlain.
  explicit ScreenFilm(const FilmSpec& spec);
  [[nodiscard]] Extent extent() const override { return strip_.extent(); }
  [[nodiscard]] Edges edges() const override { return edges_; }
  void cells(double y, int first_px, int n_px, int per_px, CellRow& out) const override;
  // As cells(), without damage: the infrared channel is then the silver alone where the dyes do not
  // leak.
  void silver_cells(double y, int first_px, int n_px, int per_px, CellRow& out) const;
  [[nodiscard]] double height_um(double x, double y) const override;

  [[nodiscard]] const FilmStrip& strip() const { return strip_; }
  [[nodiscard]] const PlacedScreen& screen() const { return screen_; }
  [[nodiscard]] const Damage& damage() const { return damage_; }
  // Share of a pixel row's place that harm covers, 0..1, at scan positions (x0 + i, y).
  void harm_row(double y, double x0, std::span<float> out) const;

 private:
  struct JoinedTents;
  struct Rows;
  // Of the pixels of a row, counted from its first.
  struct PixelRun {
    int begin = 0, end = 0;
  };
  // Per thread, one for every division of cells and each of the first runs of pixels that have it.
  static Rows& rows_of_thread(int level, int run);
  // A row of cells as it is asked for, of any fineness.
  void render(double y, bool harm, Rows& rows, CellRow& out) const;
  // The same, cells divided where the scene is too fine for them.
  void render_divided(double y, bool harm, CellRow& out) const;
  void keep_whole(PixelRun run, Rows& rows, const CellRow& out) const;
  void fade_to_whole(double y, PixelRun run, Rows& rows, CellRow& out) const;
  void divide_even(double y, int parts, bool harm, PixelRun run, Rows& rows, CellRow& out) const;
  void divide_tents(double y, int parts, bool harm, PixelRun run, Rows& rows, CellRow& out) const;
  // How often, in the block of pixels from px on.
  [[nodiscard]] int level_at(double y, int px, const CellRow& cells) const;
  void mix(double y, const PlaneRow& light, Rows& rows, CellRow& out) const;
  void apply_stains(double y, Rows& rows, CellRow& out) const;
  void apply_film_edge(CellRow& out) const;
  // Film position of scan position x, and the step along the film per step of the scan.
  [[nodiscard]] double film_x(double x) const { return strip_.film_from_scan(x, 0).x; }
  [[nodiscard]] double direction() const { return spec_.mirrored ? -1.0 : 1.0; }
  [[nodiscard]] FilmLayers layers() const;

  FilmSpec spec_;
  FilmStrip strip_;
  PlacedScreen screen_;
  std::unique_ptr<ElementPainter> painter_;  // null: no réseau
  SilverLayer silver_;
  DyeSetResponse response_, faded_response_;
  Grain grain_;
  Damage damage_;
  Edges edges_;
  std::uint64_t id_;  // of this film among all that ever were
};

}  // namespace reseau::sim
