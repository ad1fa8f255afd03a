// The one pass over the pixels that registration needs. Everywhere RGB = S * pattern, S being the
// silver; the pattern is a short Fourier series on the lattice. For every cell of 16 x 16 pixels
// the sums are kept from which the least-squares fit of that series to any window of cells, with
// any slowly varying phase, follows without looking at a pixel again:
//   N(d)    = sum S^2 E(d)            d = differences of two harmonics
//   r(c, h) = sum S X_c conj(E(h))    X_c = linear R, G, B
//   q(c)    = sum X_c^2
// with E(h) = exp(2 pi i (h_u f_u + h_v f_v) . p) at fixed carriers f_u, f_v [cy/px].
#pragma once

#include <array>
#include <complex>
#include <vector>

#include "core/geometry/vec2.h"
#include "core/screen/linear_rows.h"

namespace reseau {

struct Carriers {
  Vec2 u, v;  // [cy/px]
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
inline constexpr int kCellPx = 16;

struct Moments {
  double n0 = 0;                                                 // N(0)
  std::array<std::complex<double>, 12> n{};                      // N(kDifferences)
  std::array<double, 3> r0{};                                    // r(c, 0)
  std::array<std::array<std::complex<double>, kSeries>, 3> r{};  // r(c, kDifferences[0..3])
  std::array<double, 3> q{};
  double pixels = 0;  // that had weight
};

// Cells of the whole frame, filled band by band. Different bands may be filled by different
// threads.
class CellGrid {
 public:
  CellGrid(int width_px, int height_px, Carriers carriers);

  [[nodiscard]] int n_columns() const { return n_columns_; }
  [[nodiscard]] int n_rows() const { return n_rows_; }
  [[nodiscard]] const Carriers& carriers() const { return carriers_; }
  [[nodiscard]] Vec2 center(int column, int row) const {
    return {kCellPx * (column + 0.5) - 0.5, kCellPx * (row + 0.5) - 0.5};
  }

  // Fills every cell row that lies in `rows`; rows.first must be a multiple of kCellPx, and rows.n
  // too unless the block ends the frame. Thread-safe for disjoint blocks.
  void accumulate(const LinearRows& rows);

  [[nodiscard]] Moments cell(int column, int row) const;
  // N(0) alone: how much light the cell has.
  [[nodiscard]] double light(int column, int row) const;

 private:
  static constexpr int kStride = 1 + 24 + 3 + 24 + 3 + 1;
  void accumulate_cell(const LinearRows& rows, int column, int row, int y0, int n_lines);

  int width_px_, height_px_, n_columns_, n_rows_;
  Carriers carriers_;
  std::vector<float> cos_x_, sin_x_;  // [harmonic][x], padded to whole cells
  std::vector<float> cos_y_, sin_y_;  // [harmonic][y]
  std::vector<float> data_;           // [cell][kStride]
};

}  // namespace reseau
