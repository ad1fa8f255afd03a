// From light to silver: exposure through the réseau, spread in the emulsion, characteristic curve.
#pragma once

#include <cstdint>
#include <memory>
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
  // Means of a scene with fine detail; others are known at the middles.
  void behind_sets(double y, const CellRange& cells, PlaneRow& out) const;
  // spreads(): mean silver transmittance of each cell, one plane.
  void field(double y, const CellRange& cells, PlaneRow& out) const;

  // Areas of the sets of dyes as painter->areas(); rows that field() needed are not painted twice.
  void areas(double y, const CellRange& cells, PlaneRow& out) const;

 private:
  enum class Stage { kExposure, kSilver };
  static constexpr double kReach = 4.0;  // of a Gaussian, in standard deviations
  struct Ring;
  struct Points;
  struct Painted;
  struct Parts;
  // What a layer that spreads begins with: its exposures, or its silver where light does not
  // spread.
  struct Before {
    const SilverLayer* layer;
  };
  explicit SilverLayer(const Before& before);
  static Painted& painted_of_thread();
  // With a painter.
  const PlaneRow& painted(double y, const CellRange& cells) const;
  void exposure_behind_sets(double y, const CellRange& cells, PlaneRow& out) const;
  void apply_curve(PlaneRow& exposures) const;
  // Parts of a cell along each side in which a fine scene is exposed.
  [[nodiscard]] int parts_of(const CellRange& cells) const;
  // Mean over every cell of a row of the exposure through whatever lies over it; of the silver
  // where light does not spread. Cell after cell.
  void exposure_row(double y, const CellRange& cells, std::vector<float>& out) const;
  void exposure_of_tents(double y, const CellRange& cells, int parts,
                         std::vector<float>& out) const;
  void exposure_as_is(double y, const CellRange& cells, std::vector<float>& out) const;
  // Means of a field at height y, blurred by a Gaussian, from rows of `stage` at the grid of cells;
  // of the exposure its values at the middles of cells.
  void blurred(Stage stage, double sigma_px, double y, const CellRange& cells,
               std::vector<float>& out) const;
  // Means of the silver before it spreads, cell after cell.
  void silver_row(double y, const CellRange& cells, std::vector<float>& out) const;

  const FilmStrip& strip_;
  const ElementPainter* painter_;
  Taking taking_;
  double light_px_, silver_px_;                // standard deviations
  double reach_px_;                            // of both spreads
  double finest_ = 0;                          // of the scene [cycles/px], where it is divided
  std::uint64_t id_;                           // of this layer among all that ever were
  bool curved_ = true;                         // behind_sets() is silver, not exposure
  bool keeps_ = false;                         // the areas that it was asked for
  std::unique_ptr<const SilverLayer> before_;  // of layers that spread
};

}  // namespace reseau::sim
