// The one pass over the pixels that registration needs. Everywhere RGB = S * pattern, S being the
// silver; the pattern is a short Fourier series on the lattice. For every small cell of pixels the
// sums are kept from which the least-squares fit of that series to any window of cells, with
// any slowly varying phase, follows without looking at a pixel again:
//   N(d)    = sum S^2 E(d)            d = differences of two harmonics
//   r(c, h) = sum S X_c conj(E(h))    X_c = linear R, G, B
//   q(c)    = sum X_c^2
// with E(h) = exp(2 pi i (h_u f_u + h_v f_v) . p) at fixed carriers f_u, f_v [cy/px], or, where the
// film bends within a cell, with the phase and the slopes of a map at the middle of each cell.
#pragma once

#include <array>
#include <complex>
#include <cstddef>
#include <vector>

#include "core/geometry/vec2.h"
#include "core/screen/linear_rows.h"
#include "core/screen/screen_map.h"

namespace reseau {

struct Carriers {
  Vec2 u, v;  // [cy/px]
  // Lines alone: nothing repeats along u, which is v turned by a right angle so that maps can be
  // inverted. Harmonic (1, 0) then stands for the second of v, (0, 1) for the first.
  bool lines = false;

  // Frequency of u as harmonics count it.
  [[nodiscard]] Vec2 harmonic_u() const { return lines ? 2.0 * v : u; }
  [[nodiscard]] Mat2 matrix() const { return {u.x, u.y, v.x, v.y}; }
};

struct HarmonicIndex {
  int u, v;
};

// The half of the differences that is stored; the other half is the conjugate. The first four are
// the harmonics of the series itself.
inline constexpr std::array<HarmonicIndex, 12> kDifferences{{{1, 0},
                                                             {0, 1},
                                                             {1, 1},
                                                             {1, -1},
                                                             {2, 0},
                                                             {0, 2},
                                                             {2, 1},
                                                             {2, -1},
                                                             {1, 2},
                                                             {1, -2},
                                                             {2, 2},
                                                             {2, -2}}};
inline constexpr int kSeries = 4;

// Size of a cell [px]: along x and along y.
struct CellSize {
  int width = 16, lines = 8;
};

struct Moments {
  double n0 = 0;                                                 // N(0)
  std::array<std::complex<double>, 12> n{};                      // N(kDifferences)
  std::array<double, 3> r0{};                                    // r(c, 0)
  std::array<std::array<std::complex<double>, kSeries>, 3> r{};  // r(c, kDifferences[0..3])
  std::array<double, 3> q{};
  double pixels = 0;  // that had weight
};

// Cells of the whole frame, filled band by band. Different bands may be filled by different
// threads. Of a large frame only every n-th pair of columns of cells is kept: `keep_every`.
class CellGrid {
 public:
  CellGrid(int width_px, int height_px, Carriers carriers, CellSize size = {}, int keep_every = 1);
  // Harmonics along a map: what is left of the phase then changes little within windows.
  CellGrid(int width_px, int height_px, Carriers carriers, const ScreenMap& along, CellSize size);

  [[nodiscard]] int width_px() const { return width_px_; }
  [[nodiscard]] int height_px() const { return height_px_; }
  [[nodiscard]] int n_columns() const { return n_columns_; }
  [[nodiscard]] int n_rows() const { return n_rows_; }
  [[nodiscard]] CellSize size() const { return size_; }
  [[nodiscard]] int keep_every() const { return keep_every_; }
  [[nodiscard]] const Carriers& carriers() const { return carriers_; }
  // Screen coordinates that the harmonics have at the centre of a cell, and their slopes.
  [[nodiscard]] Vec2 phase(int column, int row) const {
    return along_.empty() ? carriers_.matrix() * center(column, row) : local(column, row).screen;
  }
  [[nodiscard]] Mat2 slopes(int column, int row) const {
    return along_.empty() ? carriers_.matrix() : local(column, row).jacobian;
  }
  // By how much harmonics turn where a map puts the centre of a cell at `screen` [periods].
  [[nodiscard]] Vec2 turn(int column, int row, Vec2 screen) const {
    const Vec2 off = screen - phase(column, row);
    return carriers_.lines ? Vec2{2 * off.y, off.y} : off;
  }
  [[nodiscard]] bool kept(int column) const { return column / 2 % keep_every_ == 0; }
  [[nodiscard]] Vec2 center(int column, int row) const {
    return {size_.width * (column + 0.5) - 0.5, size_.lines * (row + 0.5) - 0.5};
  }

  // Fills every cell row that lies in `rows`; rows.first must be a multiple of the lines of a cell,
  // and rows.n too unless the block ends the frame. Thread-safe for disjoint blocks.
  void accumulate(const LinearRows& rows);

  // Of a kept column.
  [[nodiscard]] Moments cell(int column, int row) const;
  // N(0) alone: how much light the cell has; 0 where the column is not kept.
  [[nodiscard]] double light(int column, int row) const {
    return kept(column) ? static_cast<double>(data_[index(column, row)]) : 0;
  }
  // r(c, 0) alone: of R, G and B; of a kept column.
  [[nodiscard]] std::array<double, 3> color_light(int column, int row) const;
  // Pixels of the cell that had weight, 0..1.
  [[nodiscard]] double filled(int column, int row) const;

 private:
  struct Local {
    Vec2 screen;
    Mat2 jacobian;
  };
  // What the harmonics are over one cell: a product of a row and a column of each.
  struct Waves {
    const float *cos_x, *sin_x, *cos_y, *sin_y;
    std::size_t stride_x, stride_y;  // from one harmonic to the next
  };
  struct LocalWaves;
  [[nodiscard]] const Local& local(int column, int row) const {
    return along_[static_cast<std::size_t>(row) * static_cast<std::size_t>(n_columns_) +
                  static_cast<std::size_t>(column)];
  }
  static constexpr std::size_t kStride = 1 + 24 + 3 + 24 + 3 + 1;
  template <int kQuads>
  void accumulate_cell(const LinearRows& rows, const Waves& waves, int column, int row, int y0,
                       int n_lines);
  [[nodiscard]] std::size_t index(int column, int row) const {
    const int kept_column = column / 2 / keep_every_ * 2 + column % 2;
    return (static_cast<std::size_t>(row) * static_cast<std::size_t>(n_kept_) +
            static_cast<std::size_t>(kept_column)) *
           kStride;
  }

  int width_px_, height_px_;
  CellSize size_;
  int keep_every_, n_columns_, n_rows_, n_kept_;
  Carriers carriers_;
  std::vector<Local> along_;          // [row][column], or empty
  std::vector<float> cos_x_, sin_x_;  // [harmonic][x], padded to whole cells
  std::vector<float> cos_y_, sin_y_;  // [harmonic][y]
  std::vector<float> data_;           // [row][kept column][kStride]
};

}  // namespace reseau
