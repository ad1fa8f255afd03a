#include "core/screen/screen_pattern.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "core/base/check.h"

namespace reseau {
namespace {

// Fourier coefficient of a box of width w centred at 0 in a period of 1.
double box_coefficient(double width, int harmonic) {
  if (harmonic == 0) return width;
  const double x = std::numbers::pi * harmonic;
  return std::sin(x * width) / x;
}

}  // namespace

ScreenPattern::ScreenPattern(std::string name, Vec2 period_um, std::vector<ElementShape> elements,
                             std::array<ElementLattice, 3> lattices)
    : name_(std::move(name)),
      period_um_(period_um),
      elements_(std::move(elements)),
      lattices_(lattices) {
  double total = 0;
  for (const ElementShape& e : elements_) {
    CHECK(e.color >= 0 && e.color < 3 && e.size.x > 0 && e.size.x <= 1 && e.size.y > 0 &&
          e.size.y <= 1);
    total += e.size.x * e.size.y;
  }
  CHECK(std::abs(total - 1) < 1e-9);
}

const ScreenPattern& ScreenPattern::dufaycolor() {
  static const ScreenPattern pattern = dufaycolor(kDufaycolorRedWidth, kDufaycolorGreenLength);
  return pattern;
}

ScreenPattern ScreenPattern::dufaycolor(double red, double green) {
  CHECK(red > 0.05 && red < 0.95 && green > 0.05 && green < 0.95);
  return {
      "dufaycolor",
      {49.6, 49.9},
      {{0, {0, 0.5}, {1, red}}, {1, {0, 0}, {green, 1 - red}}, {2, {0.5, 0}, {1 - green, 1 - red}}},
      // Two samples of red per period: the line runs on between the squares.
      {{{{0, 0.5}, {0.5, 1}}, {{0, 0}, {1, 1}}, {{0.5, 0}, {1, 1}}}}};
}

std::complex<double> ScreenPattern::fourier(int color, int h, int k) const {
  std::complex<double> sum = 0;
  for (const ElementShape& e : elements_) {
    if (e.color != color) continue;
    const double amplitude = box_coefficient(e.size.x, h) * box_coefficient(e.size.y, k);
    sum += std::polar(amplitude, -2 * std::numbers::pi * (h * e.center.x + k * e.center.y));
  }
  return sum;
}

}  // namespace reseau
