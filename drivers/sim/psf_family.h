// The point spread functions of one channel over all distances from focus, as short sums of
// separable kernels on a grid of cells.
#pragma once

#include <vector>

#include "drivers/sim/optical_transfer.h"

namespace reseau::sim {

// A Gaussian that is taken out of the spread functions and applied on a coarse grid.
struct WideGaussian {
  double amplitude = 0, sigma_x_px = 0, sigma_y_px = 0;
};

// Standard deviation from which on Gaussians are wide.
inline constexpr double kWidePx = 5.656854;

// The tails of a diffraction image fall with the third power of distance, whatever the focus:
// their law is a mixture of Gaussians of all widths. These are its members from kWidePx up, and the
// halo if it is as wide.
[[nodiscard]] std::vector<WideGaussian> wide_gaussians(const OpticalTransfer& transfer);

// What a grid of cells has already done to the film: each cell a mean over 1 / fine_per_px, and
// cells joined two by two with weights 1 5 10 10 5 1 until per_px are left (fine_per_px is per_px
// times a power of 2).
struct CellGrid {
  int per_px = 4, fine_per_px = 4;
  bool tents = false;  // the first cells are tents

  // Transfer along one axis.
  [[nodiscard]] double transfer(double f) const;
};

// The coarsest of the possible grids whose cells the spread functions hold no finer detail than.
[[nodiscard]] CellGrid choose_grid(int fine_per_px, const std::vector<OpticalTransfer>& transfers,
                                   int fewest_per_px = 1);

// The spread function at distance x, y [px] from its centre and defocus z is the sum over r of
// along_x(r, z, x) * along_y(r, y), as light per cell of the grid, wide Gaussians left out.
// Immutable, thread-safe.
class PsfFamily {
 public:
  // Valid for defocus from min_um to max_um.
  PsfFamily(const OpticalTransfer& transfer, const CellGrid& grid, double min_um, double max_um);

  [[nodiscard]] int rank() const { return static_cast<int>(components_.size()); }
  // Beyond so many cells component r is left out.
  [[nodiscard]] int reach_cells(int r) const {
    return components_[static_cast<std::size_t>(r)].reach_cells;
  }
  [[nodiscard]] int reach_cells() const { return reach_cells_; }
  // Weight of component r at so many cells from the centre.
  [[nodiscard]] double along_y(int r, double cells) const;

  // The tables along x. One holds, for one defocus and one fraction of a cell, the weights of all
  // components one after the other; component r has taps(r) of them from offset(r) on, the first
  // for the cell reach_cells(r) left of the one the centre lies in.
  static constexpr int kPhases = 32;
  [[nodiscard]] int n_focus() const { return n_focus_; }
  // Place of a defocus among the tables: 0 .. n_focus() - 1, clamped.
  [[nodiscard]] double focus_index(double defocus_um) const;
  [[nodiscard]] const float* table(int focus, int phase) const {
    return tables_.data() +
           (static_cast<std::size_t>(focus) * (kPhases + 1) + static_cast<std::size_t>(phase)) *
               table_size_;
  }
  [[nodiscard]] std::size_t table_size() const { return table_size_; }
  [[nodiscard]] int taps(int r) const { return components_[static_cast<std::size_t>(r)].taps; }
  [[nodiscard]] std::size_t offset(int r) const {
    return components_[static_cast<std::size_t>(r)].offset;
  }
  // Largest part of a spread function that the sum leaves out (root of squares, of its own).
  [[nodiscard]] double left_out() const { return left_out_; }

 private:
  struct Component {
    int reach_cells = 0, taps = 0;
    std::size_t offset = 0;
    std::vector<double> profile;  // along y, kProfileSteps per cell
  };
  static constexpr int kProfileSteps = 32;

  std::vector<Component> components_;
  int reach_cells_ = 0, n_focus_ = 1;
  double min_um_, step_um_ = 1, left_out_ = 0;
  std::size_t table_size_ = 0;
  std::vector<float> tables_;
};

}  // namespace reseau::sim
