// What a réseau looks like, as data: rectangles of three colours in a unit cell that repeats with
// period 1 in u and in v, and the Fourier series of each colour's mask.
#pragma once

#include <array>
#include <complex>
#include <string>
#include <vector>

#include "core/geometry/vec2.h"

namespace reseau {

// A rectangle of the unit cell, wrapped around its borders. Full width = 1 makes a line.
struct ElementShape {
  int color = 0;  // 0 red, 1 green, 2 blue
  Vec2 center;    // [periods]
  Vec2 size;      // [periods], 0..1
};

// Where the intensity of one colour is sampled: points center + (i * step.x, j * step.y).
struct ElementLattice {
  Vec2 origin;
  Vec2 step{1, 1};
};

// Microscope image by D. Pfluger (ERC FilmColors, University of Zurich), measured in Hubicka et al.
// 2025, arXiv:2501.06216: red lines 21.0 of 49.9 um; green 22.7 of 49.6 um.
inline constexpr double kDufaycolorRedWidth = 21.0 / 49.9;
inline constexpr double kDufaycolorGreenLength = 22.7 / 49.6;

// Immutable; the rectangles tile the cell without gap or overlap.
class ScreenPattern {
 public:
  ScreenPattern(std::string name, Vec2 period_um, std::vector<ElementShape> elements,
                std::array<ElementLattice, 3> lattices);

  // Dufaycolor: red lines along u at v = 0.5; between them green squares at (0, 0) and blue ones at
  // (0.5, 0).
  static const ScreenPattern& dufaycolor();
  // The same with other widths, as printings vary: the red line [periods of v] and the green square
  // [periods of u], each in 0.05..0.95.
  static ScreenPattern dufaycolor(double red_width, double green_length);

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] Vec2 period_um() const { return period_um_; }
  [[nodiscard]] const std::array<ElementLattice, 3>& lattices() const { return lattices_; }
  [[nodiscard]] double area(int color) const { return fourier(color, 0, 0).real(); }
  // Coefficient c of mask(u, v) = sum over (h, k) of c(h, k) exp(2 pi i (h u + k v)).
  [[nodiscard]] std::complex<double> fourier(int color, int h, int k) const;

 private:
  std::string name_;
  Vec2 period_um_;
  std::vector<ElementShape> elements_;
  std::array<ElementLattice, 3> lattices_;
};

}  // namespace reseau
