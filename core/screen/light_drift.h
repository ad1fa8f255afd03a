// How far a blurred réseau seems to move up the slopes of the picture behind it.
#pragma once

#include <array>
#include <vector>

#include "core/screen/cell_moments.h"
#include "core/screen/lattice_search.h"

namespace reseau {

// Cells [column0, column1) x [row0, row1) of a grid.
struct CellRange {
  int column0, column1, row0, row1;
};

// A mask m seen through a blur of variance b [px^2] in front of the light s is
// h * (s m) = s (h * m) + b grad(s) . grad(h * m) + ..., the mask b grad(ln s) away. Each colour of
// elements has a light of its own: the border between two kinds moves by the mean of both drifts.
class LightDrift {
 public:
  // What is behind the elements of each colour, cell by cell.
  LightDrift(const CellGrid& cells, const LatticeSeed& seed);

  // Mean slopes of ln s that lines of equal u, and of equal v, follow in a block [1/px].
  struct Slopes {
    Vec2 for_u, for_v;
  };
  [[nodiscard]] Slopes of_block(const CellRange& range) const;

 private:
  using Lights = std::array<float, 3>;
  [[nodiscard]] const Lights& at(int column, int row) const {
    return lights_[static_cast<std::size_t>(row) * static_cast<std::size_t>(cells_.n_columns()) +
                   static_cast<std::size_t>(column)];
  }
  [[nodiscard]] double beside(int column, int row, int step_x, int step_y, std::size_t color) const;

  const CellGrid& cells_;
  ScreenLayout layout_;
  bool grey_;
  std::array<int, 3> colors_;   // of the sites
  std::vector<Lights> lights_;  // sum of s^2 behind the elements of a colour [row][column]
};

}  // namespace reseau
