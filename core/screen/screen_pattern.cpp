#include "core/screen/screen_pattern.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "core/base/check.h"
#include "core/base/error.h"

namespace reseau {
namespace {

constexpr double kPi = std::numbers::pi;
// The part of an element's half width that counts as its middle.
constexpr double kAmid = 0.4;
constexpr double kTrimmedSide = 85.0 / 148, kGroundSide = 63.0 / 148;
constexpr double kDiscArea = 0.318;  // as in screen_description.cpp

// Fourier coefficient of a box of width w centred at 0 in a period of 1.
double box_coefficient(double width, int harmonic) {
  if (harmonic == 0) return width;
  const double x = kPi * harmonic;
  return std::sin(x * width) / x;
}

double sinc(double x) { return x == 0 ? 1 : std::sin(kPi * x) / (kPi * x); }

// Of a polygon that is even about 0, by Gauss's theorem: each edge adds the flux of a plane wave.
double polygon_coefficient(const std::vector<Vec2>& corners, int h, int k) {
  const Vec2 f{static_cast<double>(h), static_cast<double>(k)};
  double sum = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2 a = corners[i], b = corners[(i + 1) % corners.size()];
    const Vec2 edge = b - a, middle = 0.5 * (a + b), outward{edge.y, -edge.x};
    if (h == 0 && k == 0) {
      sum += 0.5 * dot(middle, outward);
    } else {
      sum += dot(f, outward) * sinc(dot(f, edge)) * std::sin(2 * kPi * dot(f, middle)) /
             (2 * kPi * dot(f, f));
    }
  }
  return sum;
}

// The square of side `side` about 0 without what lies beyond |x| + |y| = 1/2; counterclockwise.
std::vector<Vec2> trimmed_square(double side) {
  const double s = side / 2, c = 0.5 - s;
  return {{s, -c}, {s, c}, {c, s}, {-c, s}, {-s, c}, {-s, -c}, {-c, -s}, {c, -s}};
}

double disc_coefficient(double radius, int h, int k) {
  if (h == 0 && k == 0) return kPi * radius * radius;
  const double f = std::hypot(h, k);
  return radius * std::cyl_bessel_j(1, 2 * kPi * f * radius) / f;
}

double coefficient(const ElementShape& shape, int h, int k) {
  switch (shape.kind) {
    case ElementShape::Kind::kTrimmedSquare:
      return polygon_coefficient(trimmed_square(shape.size.x), h, k);
    case ElementShape::Kind::kDisc:
      return disc_coefficient(shape.size.x, h, k);
    case ElementShape::Kind::kRectangle:
      break;
  }
  return box_coefficient(shape.size.x, h) * box_coefficient(shape.size.y, k);
}

}  // namespace

ScreenPattern ScreenPattern::lines_and_squares(const std::array<int, 3>& colors,
                                               const ScreenWidths& widths) {
  const double line = widths.line, first = widths.first;
  CHECK(line > 0.05 && line < 0.95 && first > 0.05 && first < 0.95);
  ScreenPattern pattern;
  pattern.ground_ = colors[2];
  pattern.elements_ = {{colors[0], {0, 0.5}, {1, line}}, {colors[1], {0, 0}, {first, 1 - line}}};
  const auto lattice = [&](std::size_t site) -> ElementLattice& {
    return pattern.lattices_[static_cast<std::size_t>(colors[site])];
  };
  // Two samples of the line per period: it runs on between the squares.
  lattice(0) = {{0, 0.5}, {2, 0, 0, 1}, 2, {1, 0}};
  lattice(1) = {};
  lattice(2).origin = {0.5, 0};
  const double between = kAmid * (1 - line) / 2;
  pattern.middles_ = {{colors[0], {0, 0.5}, {1, kAmid * line / 2}},
                      {colors[1], {0, 0}, {kAmid * first / 2, between}},
                      {colors[2], {0.5, 0}, {kAmid * (1 - first) / 2, between}}};
  return pattern;
}

ScreenPattern ScreenPattern::two_sites(const std::array<int, 3>& colors, bool discs) {
  const double size = discs ? std::sqrt(kDiscArea / kPi) : kTrimmedSide;
  const auto kind = discs ? ElementShape::Kind::kDisc : ElementShape::Kind::kTrimmedSquare;
  ScreenPattern pattern;
  pattern.ground_ = colors[2];
  pattern.elements_ = {{colors[0], {0, 0}, {size, size}, kind},
                       {colors[1], {0.5, 0.5}, {size, size}, kind}};
  const auto lattice = [&](std::size_t site) -> ElementLattice& {
    return pattern.lattices_[static_cast<std::size_t>(colors[site])];
  };
  lattice(0) = {};
  lattice(1).origin = {0.5, 0.5};
  // The third lies at (0.5, 0) and at (0, 0.5): a lattice turned by 45 degrees.
  lattice(2) = {{0.5, 0}, {1, 1, 1, -1}, 2, {1, 1}};
  const double own = kAmid * (discs ? size : size / 2), between = kAmid * kGroundSide / 2;
  pattern.middles_ = {{colors[0], {0, 0}, {own, own}},
                      {colors[1], {0.5, 0.5}, {own, own}},
                      {colors[2], {0.5, 0}, {between, between}},
                      {colors[2], {0, 0.5}, {between, between}}};
  return pattern;
}

const ScreenPattern& ScreenPattern::dufaycolor() {
  static const ScreenPattern pattern = lines_and_squares({0, 1, 2}, {});
  return pattern;
}

std::complex<double> ScreenPattern::fourier(int color, int h, int k) const {
  std::complex<double> sum = color == ground_ && h == 0 && k == 0 ? 1 : 0;
  for (const ElementShape& e : elements_) {
    if (color != ground_ && e.color != color) continue;
    const double amplitude = (color == ground_ ? -1 : 1) * coefficient(e, h, k);
    sum += std::polar(1.0, -2 * kPi * (h * e.center.x + k * e.center.y)) * amplitude;
  }
  return sum;
}

PrintedScreen printed_screen(std::string_view name) {
  const ScreenKind kind = screen_kind(name);
  const auto widths = [](ScreenKind of) {
    const ScreenSizes sizes = usual_sizes(of);
    return ScreenWidths{sizes.line_width, sizes.first_length};
  };
  switch (kind) {
    case ScreenKind::kDufaycolor:
    case ScreenKind::kDufaycolorGawain:
    case ScreenKind::kDufaycolorPenichon:
    case ScreenKind::kDufaycolorClyneColor:
    case ScreenKind::kDufaycolorClyneBw:
      return {true, {0, 1, 2}, widths(kind)};
    case ScreenKind::kSpicerDufayGreen:
    case ScreenKind::kDioptichrome:
      return {true, {1, 0, 2}, widths(kind)};
    case ScreenKind::kSpicerDufayBlue:
    case ScreenKind::kImprovedDioptichrome:
    case ScreenKind::kOmnicolore:
      return {true, {2, 0, 1}, widths(kind)};
    case ScreenKind::kPaget:
    case ScreenKind::kFinlay:
      return {false, {0, 1, 2}, {}, false};
    case ScreenKind::kThames:
      return {false, {0, 1, 2}, {}, true};
    case ScreenKind::kJoly:
    case ScreenKind::kWarnerPowrie:
      break;
  }
  throw InputError("The réseau is one of lines alone (" + std::string(name) +
                   "); no picture can be made of it yet.");
}

}  // namespace reseau
