// From light to silver: exposure through the réseau, spread in the emulsion, characteristic curve.
#pragma once

#include <cstdint>
#include <vector>

#include "drivers/sim/film/element_painter.h"
#include "drivers/sim/film/plane_row.h"
#include "drivers/sim/film_strip.h"

namespace reseau::sim {

// Immutable, thread-safe; threads keep a few rows of their own.
class SilverLayer {
 public:
  // Borrows both. painter is null for a film without réseau, where the silver is that of the
  // luminance.
  SilverLayer(const FilmSpec& spec, const FilmStrip& strip, const ElementPainter* painter);

  // Whether light or silver spreads beyond its element. Then the silver is one field; otherwise it
  // has a value of its own behind each set of dyes.
  [[nodiscard]] bool spreads() const { return light_px_ > 0 || silver_px_ > 0; }

  // Silver transmittance of each cell behind painter->sets()[plane]; of one plane without painter.
  // tents (CellRow): means over them of a scene with fine detail; others are known at the middles.
  void behind_sets(double y, int first_px, int n_px, int per_px, PlaneRow& out, bool tents) const;
  // spreads(): silver transmittance of each cell, one plane.
  void field(double y, int first_px, int n_px, int per_px, PlaneRow& out) const;

  // Areas of the sets of dyes as painter->areas(); rows that field() needed are not painted twice.
  void areas(double y, int first_px, int n_px, int per_px, PlaneRow& out, bool tents) const;

 private:
  enum class Stage { kExposure, kSilver };
  struct Ring;
  struct Painted;
  static Painted& painted_of_thread();
  // Null without a painter.
  const PlaneRow* painted(double y, int first_px, int n_px, int per_px) const;
  void exposure_behind_sets(double y, int first_px, int n_px, int per_px, PlaneRow& out,
                            bool tents = false) const;
  // Parts of a cell along each side in which a fine scene is exposed.
  [[nodiscard]] int parts_of(int per_px) const;
  // Mean over every cell of a row of the exposure through whatever lies over it; of the silver
  // where light does not spread.
  void exposure_row(double y, int first_px, int n_px, int per_px, std::vector<float>& out) const;
  void exposure_as_is(double y, int first_px, int n_px, int per_px, const PlaneRow* areas,
                      std::vector<float>& out) const;
  void apply_curve(std::vector<float>& exposure) const;
  // A field at height y, blurred by sigma_px, from rows of `stage` at the grid of cells.
  void blurred(Stage stage, double sigma_px, double y, int first_px, int n_px, int per_px,
               std::vector<float>& out) const;
  // The silver before it spreads, pixel after pixel.
  void silver_row(double y, int first_px, int n_px, int per_px, std::vector<float>& out) const;

  const FilmStrip& strip_;
  const ElementPainter* painter_;
  Taking taking_;
  double light_px_, silver_px_;  // standard deviations
  double reach_px_;              // of both spreads
  double finest_ = 0;            // of the scene [cycles/px], where it is divided
  std::uint64_t id_;             // of this layer among all that ever were
};

}  // namespace reseau::sim
