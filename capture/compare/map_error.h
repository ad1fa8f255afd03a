// How far one registration lies from another, in pixels of the scan.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

namespace reseau::compare {

// u and v [periods] of the rows first_row .. first_row + n_rows - 1, [row][pixel][u, v].
using MapRows = std::function<void(int first_row, int n_rows, std::span<float> out)>;

// Both maps count periods of the same lattice, but each may begin at any element and run either way
// along each axis. The equivalence that makes the directions of B those of A:
//   (u, v) of A  ~  sign * (u, v) of B, exchanged first when `swapped`, minus whole periods.
// Directions are judged by the gradients alone, so that no displacement is mistaken for one.
struct MapEquivalence {
  bool swapped = false;  // u of one is v of the other: not the same elements
  int sign_u = 1, sign_v = 1;
  double periods_u = 0, periods_v = 0;  // whole numbers
  // How badly the lattices fit even so: rms difference of the gradients over their rms.
  double gradient_mismatch = 0;
};

struct FieldCell {
  double x_px = 0, y_px = 0;    // middle of the cell
  double dx_px = 0, dy_px = 0;  // mean displacement
  double rms_px = 0;            // of the length
  long long n = 0;
};

// The displacement at pixel p is d when B says at p what A says at p + d: minus the shift of the
// pattern in B against A. From the difference of the coordinates by the local Jacobian of A.
struct MapError {
  MapEquivalence equivalence;
  long long n = 0, n_not_finite = 0;
  // Pixels where the two differ by a whole period more than elsewhere: one of them lost count. The
  // displacement is taken without that period.
  long long n_slipped = 0;
  double mean_x_px = 0, mean_y_px = 0;
  double rms_px = 0, median_px = 0, p95_px = 0, max_px = 0;  // of the length
  double rms_without_mean_px = 0;
  double period_u_px = 0, period_v_px = 0;  // mean lengths of the periods of A
  int field_columns = 0, field_rows = 0;
  std::vector<FieldCell> field;  // row by row
};

// Both maps have this size. `border_px` is left out on each side. Memory: one float per pixel and a
// few rows. Throws what the rows throw. Cells of the field without pixels have n = 0.
[[nodiscard]] MapError compare_maps(int width_px, int height_px, int border_px, const MapRows& a,
                                    const MapRows& b);

}  // namespace reseau::compare
