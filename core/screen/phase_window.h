// Blocks of cells as windows of one fit: what following a réseau and measuring it share. Include
// from .cpp files of this folder only.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/screen/phase_samples.h"

namespace reseau {

// Surer than this, or a sample is not used at all [1/periods^2]: one sigma of 0.12 periods.
inline constexpr double kLeastInfo = 1 / (0.12 * 0.12);

inline CellRange range_of(const CellGrid& cells, const BlockShape& shape, int i, int j, int reach) {
  const int width = shape.columns * cells.keep_every();
  return {std::max(0, i * width - reach), std::min(cells.n_columns(), (i + 1) * width + reach),
          std::max(0, j * shape.rows - reach),
          std::min(cells.n_rows(), (j + 1) * shape.rows + reach)};
}

struct BlockGrid {
  int nx, ny;
  BlockGrid(const CellGrid& cells, const BlockShape& shape)
      : nx((cells.n_columns() + shape.columns * cells.keep_every() - 1) /
           (shape.columns * cells.keep_every())),
        ny((cells.n_rows() + shape.rows - 1) / shape.rows) {}
};

// The sums of a block, its phases turned by `screen_at`, a prediction of screen coordinates.
struct Window {
  Moments moments;
  Vec2 center;                      // of the light
  double sum = 0, sum_squares = 0;  // of the light of its cells
  double most = 0;                  // of a cell
  int n = 0;

  // Standard deviation of the light of its cells over their mean.
  [[nodiscard]] double unevenness() const {
    if (n < 2 || !(sum > 0)) return 0;
    const double mean = sum / n;
    return std::sqrt(std::max(sum_squares / n - mean * mean, 0.0)) / mean;
  }
};

template <typename Predict>
Window window_of(const CellGrid& cells, const CellRange& range, const Predict& screen_at) {
  Window window;
  for (int r = range.row0; r < range.row1; ++r) {
    for (int c = range.column0; c < range.column1; ++c) {
      const double light = cells.light(c, r);
      if (!(light > 0)) continue;
      const Vec2 p = cells.center(c, r);
      add_rephased(window.moments, cells.cell(c, r), cells.turn(c, r, screen_at(c, r, p)), 1);
      window.center = window.center + light * p;
      window.sum += light;
      window.sum_squares += light * light;
      window.most = std::max(window.most, light);
      ++window.n;
    }
  }
  if (window.moments.n0 > 0) window.center = (1 / window.moments.n0) * window.center;
  return window;
}

// False where a window says nothing.
[[nodiscard]] bool make_sample(const Shift& shift, Vec2 p, Vec2 predicted, bool lines,
                               PhaseSample& sample);

}  // namespace reseau
