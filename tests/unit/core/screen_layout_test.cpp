#include "core/screen/screen_layout.h"

#include <array>
#include <complex>
#include <cstddef>
#include <numbers>

#include <gtest/gtest.h>

namespace reseau {
namespace {

TEST(ScreenLayout, SitesTileTheCell) {
  for (const ScreenLayout layout : {ScreenLayout::kLinesAndSquares, ScreenLayout::kTwoSites}) {
    const SiteSeries& series = site_series(layout);
    for (std::size_t h = 0; h < series[0].size(); ++h) {
      EXPECT_NEAR(series[0][h] + series[1][h] + series[2][h], h == 0 ? 1 : 0, 1e-6) << h;
    }
  }
}

TEST(ScreenLayout, TwoSitesHaveTheAreasOfPaget) {
  const SiteSeries& series = site_series(ScreenLayout::kTwoSites);
  const double small = 63.0 / 148;
  EXPECT_NEAR(series[2][0], 2 * small * small, 0.01);
  EXPECT_NEAR(series[0][0], series[1][0], 1e-3);
}

TEST(ScreenLayout, EverySiteHasAColourOfItsOwn) {
  for (const ScreenLayout layout : {ScreenLayout::kLinesAndSquares, ScreenLayout::kTwoSites}) {
    for (const int special : {0, 1, 2}) {
      const auto colors = site_colors(layout, special);
      EXPECT_EQ(colors[0] + colors[1] + colors[2], 3);
      EXPECT_NE(colors[0], colors[1]);
      EXPECT_EQ(colors[static_cast<std::size_t>(layout_sites(layout).special)], special);
    }
  }
}

TEST(ScreenLayout, TwoHarmonicsOfLinesTellTheirOrigin) {
  // Lights of three channels behind red, green and blue lines, and a blur that weakens the second.
  const double lights[3][3] = {{0.9, 0.1, 0.2}, {0.2, 0.7, 0.1}, {0.05, 0.15, 0.8}};
  for (const double v : {-0.15, -0.03, 0.0, 0.08, 0.16}) {
    std::array<std::complex<double>, 3> first, second;
    for (std::size_t c = 0; c < 3; ++c) {
      for (int site = 0; site < 3; ++site) {
        first[c] += lights[c][site] * line_harmonic(site, 1);
        second[c] += 0.3 * lights[c][site] * line_harmonic(site, 2);
      }
      first[c] *= std::polar(1.0, 2 * std::numbers::pi * v);
      second[c] *= std::polar(1.0, 4 * std::numbers::pi * v);
    }
    EXPECT_NEAR(line_origin(first, second), v, 1e-12);
  }
}

TEST(ScreenLayout, ThePeriodTellsJolyFromWarnerPowrie) {
  EXPECT_EQ(name_screen({ScreenLayout::kLines, 0, 0.5, 0.1, 300})[0].name, "joly");
  EXPECT_EQ(name_screen({ScreenLayout::kLines, 0, 0.5, 0.1, 127})[0].name, "warner-powrie");
}

TEST(ScreenLayout, RedLinesAreDufaycolorWhateverThePeriod) {
  for (const double period_um : {0.0, 25.0, 50.0, 80.0}) {
    const auto guesses = name_screen({ScreenLayout::kLinesAndSquares, 0, 0.6, 0.2, period_um});
    EXPECT_EQ(guesses[0].name, "dufaycolor") << period_um;
    double total = 0;
    for (const ScreenGuess& guess : guesses) total += guess.probability;
    EXPECT_NEAR(total, 1, 1e-9);
  }
}

TEST(ScreenLayout, ThePeriodTellsPagetFromFinlay) {
  EXPECT_EQ(name_screen({ScreenLayout::kTwoSites, 2, 0.6, 0.2, 148})[0].name, "paget");
  EXPECT_EQ(name_screen({ScreenLayout::kTwoSites, 2, 0.6, 0.2, 100})[0].name, "finlay");
  // Thames is as coarse and looks alike: not surely Finlay.
  EXPECT_LT(name_screen({ScreenLayout::kTwoSites, 2, 0.6, 0.2, 100})[0].probability, 0.8);
}

}  // namespace
}  // namespace reseau
