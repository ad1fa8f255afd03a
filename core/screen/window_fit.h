// Least squares on a window of cells: the colour series of the réseau, and how far the réseau lies
// from where a map predicts it.
#pragma once

#include <array>
#include <complex>

#include "core/screen/cell_moments.h"

namespace reseau {

// Coefficients of X_c / S = sum over h of a(c, h) exp(2 pi i h . s), s = screen coordinates:
// a(c, 0) real, then the harmonics u, v, u + v, u - v; their negatives are the conjugates.
struct ColorSeries {
  std::array<double, 3> mean{};
  std::array<std::array<std::complex<double>, kSeries>, 3> harmonic{};
  // Lines alone: harmonic 1 is the first along v and harmonic 0 the second (see Carriers), the
  // others are zero; not even about the origin.
  bool lines = false;
};

// Adds a cell to a window: the phase of the carriers is replaced by that of a map, of which
// `screen_minus_carrier` [periods] is the difference at the centre of the cell.
void add_rephased(Moments& window, const Moments& cell, Vec2 screen_minus_carrier, double weight);

// Series that fits the window best, of the kind that `series.lines` says. False when the window
// does not determine it.
[[nodiscard]] bool fit_series(const Moments& window, ColorSeries& series);

struct Shift {
  Vec2 delta;  // true screen coordinates minus predicted [periods]
  // Information (inverse covariance) of delta [1/periods^2], from the residual noise of this
  // window.
  double info_uu = 0, info_uv = 0, info_vv = 0;
  double modulation = 0;  // fitted amplitude of the pattern over the expected one; 1 = as expected
};

// Gauss-Newton on delta with the mean and the contrast of each channel free. Returns zero
// information when the window says nothing.
[[nodiscard]] Shift fit_shift(const Moments& window, const ColorSeries& series);

}  // namespace reseau
