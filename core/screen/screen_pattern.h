// What a réseau looks like, as data: shapes of three colours in a unit cell that repeats with
// period 1 in u and in v, and the Fourier series of each colour's mask.
#pragma once

#include <array>
#include <complex>
#include <string>
#include <string_view>
#include <vector>

#include "core/geometry/vec2.h"
#include "core/screen/screen_description.h"

namespace reseau {

// A shape of the unit cell, wrapped around its borders. What no shape covers has the colour of the
// ground.
struct ElementShape {
  enum class Kind {
    kRectangle,      // a full width of 1 makes a line
    kTrimmedSquare,  // of side size.x, its corners cut where |x| + |y| exceeds half a period
    kDisc            // of radius size.x
  };
  int color = 0;  // 0 red, 1 green, 2 blue
  Vec2 center;    // [periods]
  Vec2 size;      // [periods]
  Kind kind = Kind::kRectangle;
};

// Where the intensity of one colour is sampled: every point with whole index = to_index * (s -
// origin). One of n_sites kinds: site = (i * site_step[0] + j * site_step[1]) modulo n_sites.
struct ElementLattice {
  Vec2 origin;
  Mat2 to_index{1, 0, 0, 1};
  int n_sites = 1;
  std::array<int, 2> site_step{};

  [[nodiscard]] int site(int i, int j) const {
    const int at = (i * site_step[0] + j * site_step[1]) % n_sites;
    return at < 0 ? at + n_sites : at;
  }
};

// A place well inside an element, where a pixel sees little else: |s - middle| < half.
struct ElementMiddle {
  int color = 0;
  Vec2 middle, half;  // [periods]
};

// Microscope image by D. Pfluger (ERC FilmColors, University of Zurich), measured in Hubicka et al.
// 2025, arXiv:2501.06216: red lines 21.0 of 49.9 um; green 22.7 of 49.6 um.
inline constexpr double kDufaycolorRedWidth = 21.0 / 49.9;
inline constexpr double kDufaycolorGreenLength = 22.7 / 49.6;

// What differs from one printing of lines and squares to the next [periods].
struct ScreenWidths {
  double line = kDufaycolorRedWidth;      // across v: red in a Dufaycolor
  double first = kDufaycolorGreenLength;  // of the square at (0, 0), along u: green there
};

// Immutable. Even about (0, 0): all coefficients are real.
class ScreenPattern {
 public:
  // Lines of one colour along u at v = 0.5; between them squares of a second colour at (0, 0) and
  // of the third at (0.5, 0). colors: line, first, second; widths each in 0.05..0.95.
  static ScreenPattern lines_and_squares(const std::array<int, 3>& colors,
                                         const ScreenWidths& widths);
  // Elements of one colour at (0, 0), as large ones of the second at (0.5, 0.5), the third between:
  // squares whose corners touch (Paget, Finlay: sides of 85 um in 148, Wall 1925), or discs of
  // 31.8 % of the area (Thames).
  static ScreenPattern two_sites(const std::array<int, 3>& colors, bool discs);
  static const ScreenPattern& dufaycolor();

  [[nodiscard]] const std::array<ElementLattice, 3>& lattices() const { return lattices_; }
  // Two or more for each colour.
  [[nodiscard]] const std::vector<ElementMiddle>& middles() const { return middles_; }
  [[nodiscard]] double area(int color) const { return fourier(color, 0, 0).real(); }
  // Coefficient c of mask(u, v) = sum over (h, k) of c(h, k) exp(2 pi i (h u + k v)).
  [[nodiscard]] std::complex<double> fourier(int color, int h, int k) const;

 private:
  ScreenPattern() = default;

  int ground_ = 2;
  std::vector<ElementShape> elements_;
  std::array<ElementLattice, 3> lattices_;
  std::vector<ElementMiddle> middles_;
};

// A family of screens in the colours of one that was made.
struct PrintedScreen {
  bool lines = true;                   // lines and squares, else two sites
  std::array<int, 3> colors{0, 1, 2};  // of the sites, as above
  ScreenWidths usual;                  // of lines and squares
  bool discs = false;

  [[nodiscard]] ScreenPattern pattern(const ScreenWidths& widths) const {
    return lines ? ScreenPattern::lines_and_squares(colors, widths)
                 : ScreenPattern::two_sites(colors, discs);
  }
};
// Throws InputError for a name that is none of screen_names(), or of lines alone (Joly).
[[nodiscard]] PrintedScreen printed_screen(std::string_view name);

}  // namespace reseau
