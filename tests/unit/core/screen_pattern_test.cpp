// Closed forms of the réseau's Fourier series against sums over a fine grid of the cell.
#include "core/screen/screen_pattern.h"

#include <array>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <set>
#include <utility>

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace reseau {
namespace {

double nearest(double x) { return x - std::round(x); }

using ColorAt = std::function<int(double u, double v)>;

void expect_series(const ScreenPattern& pattern, const ColorAt& color_at) {
  constexpr int kGrid = 400, kMost = 4;
  constexpr double kTwoPi = 2 * std::numbers::pi;
  std::array<std::array<std::array<std::complex<double>, 2 * kMost + 1>, kMost + 1>, 3> sum{};
  for (int j = 0; j < kGrid; ++j) {
    for (int i = 0; i < kGrid; ++i) {
      const double u = (i + 0.5) / kGrid, v = (j + 0.5) / kGrid;
      auto& of_color = sum[static_cast<std::size_t>(color_at(u, v))];
      for (int h = 0; h <= kMost; ++h) {
        for (int k = -kMost; k <= kMost; ++k)
          of_color[static_cast<std::size_t>(h)][static_cast<std::size_t>(k + kMost)] +=
              std::polar(1.0 / (kGrid * kGrid), -kTwoPi * (h * u + k * v));
      }
    }
  }
  for (int color = 0; color < 3; ++color) {
    for (int h = 0; h <= kMost; ++h) {
      for (int k = -kMost; k <= kMost; ++k) {
        const auto expected = sum[static_cast<std::size_t>(color)][static_cast<std::size_t>(h)]
                                 [static_cast<std::size_t>(k + kMost)];
        EXPECT_NEAR(std::abs(pattern.fourier(color, h, k) - expected), 0, 3e-3)
            << color << " " << h << " " << k;
      }
    }
  }
}

TEST(ScreenPattern, SeriesOfLinesAndSquares) {
  const ScreenWidths widths{0.31, 0.6};
  expect_series(ScreenPattern::lines_and_squares({2, 0, 1}, widths), [&](double u, double v) {
    if (std::abs(nearest(v - 0.5)) < widths.line / 2) return 2;
    return std::abs(nearest(u)) < widths.first / 2 ? 0 : 1;
  });
}

TEST(ScreenPattern, SeriesOfTrimmedSquares) {
  const auto inside = [](double u, double v) {
    const double a = std::abs(nearest(u)), b = std::abs(nearest(v));
    return std::max(a, b) < 42.5 / 148 && a + b < 0.5;
  };
  expect_series(ScreenPattern::two_sites({0, 1, 2}, false), [&](double u, double v) {
    if (inside(u, v)) return 0;
    return inside(u - 0.5, v - 0.5) ? 1 : 2;
  });
}

TEST(ScreenPattern, SeriesOfDiscs) {
  const auto inside = [](double u, double v) {
    return std::hypot(nearest(u), nearest(v)) < std::sqrt(0.318 / std::numbers::pi);
  };
  expect_series(ScreenPattern::two_sites({1, 0, 2}, true), [&](double u, double v) {
    if (inside(u, v)) return 1;
    return inside(u - 0.5, v - 0.5) ? 0 : 2;
  });
}

// Areas are those of the description, whose own geometry the simulated film prints.
TEST(ScreenPattern, AreasOfEveryScreenThatWasMade) {
  for (const ScreenName& screen : screen_names()) {
    if (screen.kind == ScreenKind::kJoly || screen.kind == ScreenKind::kWarnerPowrie) {
      EXPECT_THROW((void)printed_screen(screen.name), InputError);
      continue;
    }
    const PrintedScreen printed = printed_screen(screen.name);
    const ScreenPattern pattern = printed.pattern(printed.usual);
    const ScreenDescription made = describe_screen(screen.kind);
    for (int color = 0; color < 3; ++color)
      EXPECT_NEAR(pattern.area(color), made.areas[static_cast<std::size_t>(color)], 2e-3)
          << screen.name << " " << color;
  }
}

// Every point of a lattice lies in an element of its colour, and every kind of site is met.
TEST(ScreenPattern, LatticesLieInTheirElements) {
  for (const ScreenPattern& pattern :
       {ScreenPattern::dufaycolor(), ScreenPattern::two_sites({0, 1, 2}, false)}) {
    for (int color = 0; color < 3; ++color) {
      const ElementLattice& lattice = pattern.lattices()[static_cast<std::size_t>(color)];
      const Mat2 from_index = lattice.to_index.inverse();
      std::array<std::set<std::pair<int, int>>, 2> places;
      for (int j = -3; j <= 3; ++j) {
        for (int i = -3; i <= 3; ++i) {
          const Vec2 s = lattice.origin + from_index * Vec2{double(i), double(j)};
          bool amid = false;
          for (const ElementMiddle& m : pattern.middles()) {
            amid = amid || (m.color == color && std::abs(nearest(s.x - m.middle.x)) < m.half.x &&
                            std::abs(nearest(s.y - m.middle.y)) < m.half.y);
          }
          EXPECT_TRUE(amid) << color << ": " << s.x << ", " << s.y;
          const int site = lattice.site(i, j);
          ASSERT_GE(site, 0);
          ASSERT_LT(site, lattice.n_sites);
          // Within the cell, in quarters of a period.
          places[static_cast<std::size_t>(site)].insert(
              {int(std::lround(4 * (s.x - std::floor(s.x)))) % 4,
               int(std::lround(4 * (s.y - std::floor(s.y)))) % 4});
        }
      }
      for (int site = 0; site < lattice.n_sites; ++site)
        EXPECT_EQ(places[static_cast<std::size_t>(site)].size(), 1U) << color << " " << site;
    }
  }
}

}  // namespace
}  // namespace reseau
