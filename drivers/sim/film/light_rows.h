// What passes the silver behind each set of dyes, row of cells by row of cells.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "drivers/sim/film/damage.h"
#include "drivers/sim/film/element_painter.h"
#include "drivers/sim/film/grain.h"
#include "drivers/sim/film/plane_row.h"
#include "drivers/sim/film/silver_layer.h"
#include "drivers/sim/film_strip.h"

namespace reseau::sim {

// The layers that a row of cells is made of. Borrowed.
struct FilmLayers {
  const FilmStrip& strip;
  const ElementPainter* painter;  // null: no réseau
  const SilverLayer& silver;
  const Grain* grain;    // null: none
  const Damage* damage;  // null: none
  bool mirrored;
  std::uint64_t id;  // of this film among all that ever were
};

// Remembers the rows around the latest, for each is its neighbours' neighbour. Rows are asked for
// at the heights of the grid of cells, cheapest in ascending order. Thread-bound.
class LightRows {
 public:
  // Means over the cells of area x silver, one plane per set of dyes. harm: with dust, bubbles and
  // scratches. Valid until the next call.
  const PlaneRow& row(const FilmLayers& film, double y, const CellRange& cells, bool harm);

 private:
  // At the middles of cells: grain x what harm lets through of it. Means over cells: that alone,
  // and what a scratch has bared.
  struct Texture {
    std::int64_t row = INT64_MIN;
    bool harmed = false;
    std::vector<float> grain, whole, bared;  // cell after cell
  };
  struct Made {
    std::int64_t row = INT64_MIN;
    PlaneRow areas, silver;  // silver behind each set of dyes, or one field
  };
  struct Finished {
    std::int64_t row = INT64_MIN;
    PlaneRow silver;  // with its texture, means over the cells
  };
  [[nodiscard]] double height_of(std::int64_t row) const {
    return (static_cast<double>(row) + 0.5) / cells_.per_px - 0.5;
  }
  const Made& made(std::int64_t row);
  const Texture& texture(std::int64_t row);
  // Whole and bared parts of cells from film position x on, a step apart; false if all are whole.
  bool harm(double y, double x, double step, Texture& t);
  const Finished& finished(std::int64_t row);
  void bend_across(const PlaneRow& silver, int n_planes, PlaneRow& to) const;
  void apply_texture(std::int64_t row, PlaneRow& silver);
  [[nodiscard]] bool has_grain() const {
    return film_->grain != nullptr && !film_->grain->is_off();
  }
  [[nodiscard]] int plane_of(int set) const { return film_->silver.spreads() ? 0 : set; }

  const FilmLayers* film_ = nullptr;  // of the present call
  std::uint64_t id_ = 0;
  CellRange cells_;  // two pixels more on both sides than asked for
  bool harm_ = false, coarse_ = false;
  std::array<Made, 8> made_;
  std::array<Texture, 4> textures_;
  std::array<Finished, 4> finished_;
  PlaneRow light_;
  std::vector<float> depth_, means_[3], point_[2];
};

}  // namespace reseau::sim
