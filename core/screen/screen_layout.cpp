#include "core/screen/screen_layout.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "core/screen/screen_description.h"
#include "core/screen/screen_pattern.h"

namespace reseau {
namespace {

SiteSeries lines_and_squares_series() {
  const ScreenPattern& pattern = ScreenPattern::dufaycolor();
  SiteSeries series{};
  for (int site = 0; site < 3; ++site) {
    auto& out = series[static_cast<std::size_t>(site)];
    out[0] = pattern.area(site);
    for (std::size_t h = 0; h < kTileHarmonics.size(); ++h)
      out[h + 1] = pattern.fourier(site, kTileHarmonics[h].u, kTileHarmonics[h].v).real();
  }
  return series;
}

// Squares of Paget and discs of Thames are alike in these harmonics to some percent; the squares
// stand for both. Sums over a fine grid of the cell.
SiteSeries two_sites_series() {
  constexpr int kGrid = 256;
  constexpr double kLarge = 85.0 / 148;  // Wall 1925, as in screen_description.cpp
  const auto site_at = [](double u, double v) {
    const auto inside = [](double a, double b) {
      a -= std::round(a);
      b -= std::round(b);
      return std::abs(a) < kLarge / 2 && std::abs(b) < kLarge / 2 &&
             std::abs(a) + std::abs(b) < 0.5;
    };
    if (inside(u, v)) return std::size_t{0};
    return inside(u - 0.5, v - 0.5) ? std::size_t{1} : std::size_t{2};
  };
  SiteSeries series{};
  for (int j = 0; j < kGrid; ++j) {
    for (int i = 0; i < kGrid; ++i) {
      const double u = (i + 0.5) / kGrid, v = (j + 0.5) / kGrid;
      auto& out = series[site_at(u, v)];
      out[0] += 1;
      for (std::size_t h = 0; h < kTileHarmonics.size(); ++h)
        out[h + 1] +=
            std::cos(2 * std::numbers::pi * (kTileHarmonics[h].u * u + kTileHarmonics[h].v * v));
    }
  }
  for (auto& site : series) {
    for (double& value : site) value /= static_cast<double>(kGrid) * kGrid;
  }
  return series;
}

SiteSeries three_lines_series() {
  SiteSeries series{};
  for (int site = 0; site < 3; ++site) {
    auto& out = series[static_cast<std::size_t>(site)];
    out[0] = 1.0 / 3;
    for (std::size_t h = 0; h < kTileHarmonics.size(); ++h) {
      if (kTileHarmonics[h].u == 0) out[h + 1] = line_harmonic(site, kTileHarmonics[h].v).real();
    }
  }
  return series;
}

struct Made {
  ScreenKind kind;
  ScreenLayout layout;
  int special_color;
  double prior;
};

// Priors among screens that only the period tells apart: about how often one meets them.
constexpr std::array<Made, 11> kMade{
    {{ScreenKind::kDufaycolor, ScreenLayout::kLinesAndSquares, kRedElement, 1},
     {ScreenKind::kSpicerDufayBlue, ScreenLayout::kLinesAndSquares, kBlueElement, 0.2},
     {ScreenKind::kOmnicolore, ScreenLayout::kLinesAndSquares, kBlueElement, 0.45},
     {ScreenKind::kImprovedDioptichrome, ScreenLayout::kLinesAndSquares, kBlueElement, 0.35},
     {ScreenKind::kDioptichrome, ScreenLayout::kLinesAndSquares, kGreenElement, 0.8},
     {ScreenKind::kSpicerDufayGreen, ScreenLayout::kLinesAndSquares, kGreenElement, 0.2},
     {ScreenKind::kPaget, ScreenLayout::kTwoSites, kBlueElement, 0.5},
     {ScreenKind::kFinlay, ScreenLayout::kTwoSites, kBlueElement, 0.3},
     {ScreenKind::kThames, ScreenLayout::kTwoSites, kBlueElement, 0.2},
     {ScreenKind::kJoly, ScreenLayout::kLines, kRedElement, 0.3},
     {ScreenKind::kWarnerPowrie, ScreenLayout::kLines, kRedElement, 0.2}}};

}  // namespace

ScreenLayout layout_of(ScreenKind kind) {
  switch (kind) {
    case ScreenKind::kPaget:
    case ScreenKind::kFinlay:
    case ScreenKind::kThames:
      return ScreenLayout::kTwoSites;
    case ScreenKind::kJoly:
    case ScreenKind::kWarnerPowrie:
      return ScreenLayout::kLines;
    default:
      return ScreenLayout::kLinesAndSquares;
  }
}

LayoutSites layout_sites(ScreenLayout layout) {
  if (layout == ScreenLayout::kTwoSites) return {2, {0, 1}, {0.5, 0.5}, true};
  if (layout == ScreenLayout::kLines) return {0, {1, 2}, {0, 1.0 / 3}, false};
  return {0, {1, 2}, {0.5, 0}, false};
}

const SiteSeries& site_series(ScreenLayout layout) {
  static const SiteSeries lines = lines_and_squares_series();
  static const SiteSeries sites = two_sites_series();
  static const SiteSeries alone = three_lines_series();
  if (layout == ScreenLayout::kLines) return alone;
  return layout == ScreenLayout::kTwoSites ? sites : lines;
}

std::complex<double> line_harmonic(int site, int h) {
  const double x = std::numbers::pi * h;
  const double width = h == 0 ? 1.0 / 3 : std::sin(x / 3) / x;
  return std::polar(1.0, -2 * x * (1.0 / 6 + site / 3.0)) * width;
}

double line_origin(const std::array<std::complex<double>, 3>& first,
                   const std::array<std::complex<double>, 3>& second) {
  std::complex<double> sum = 0;
  for (std::size_t c = 0; c < 3; ++c) sum -= first[c] * second[c];
  return std::abs(sum) > 0 ? std::arg(sum) / (6 * std::numbers::pi) : 0;
}

std::array<int, 3> site_colors(ScreenLayout layout, int special_color) {
  if (layout == ScreenLayout::kLines) return {kRedElement, kGreenElement, kBlueElement};
  // The first of the pair: green beside red lines, red beside lines of other colours.
  const int first = special_color == kRedElement ? kGreenElement : kRedElement;
  const int second = 3 - special_color - first;
  if (layout == ScreenLayout::kTwoSites) return {first, second, special_color};
  return {special_color, first, second};
}

std::vector<ScreenKind> dufaycolor_printings() {
  std::vector<ScreenKind> kinds;
  for (const ScreenName& screen : screen_names()) {
    if (is_dufaycolor(screen.kind)) kinds.push_back(screen.kind);
  }
  return kinds;
}

std::vector<ScreenKind> kinds_of(ScreenLayout layout, int special_color) {
  std::vector<ScreenKind> kinds;
  for (const Made& screen : kMade) {
    if (screen.layout == layout && (special_color < 0 || screen.special_color == special_color))
      kinds.push_back(screen.kind);
  }
  return kinds;
}

std::vector<ScreenGuess> name_screen(const ScreenEvidence& evidence) {
  std::vector<ScreenGuess> guesses;
  double total = 0;
  for (const Made& screen : kMade) {
    double weight = screen.prior;
    // A share of one hundredth more that is explained is e^0.6 in favour.
    if (screen.layout != evidence.layout)
      weight *= std::exp(60 * std::min(evidence.other_explained - evidence.explained, 0.0));
    // What repeats in two directions is not lines alone.
    if (screen.layout == ScreenLayout::kLines && evidence.layout != ScreenLayout::kLines)
      weight *= 1e-3;
    if (evidence.special_color >= 0 && screen.special_color != evidence.special_color)
      weight *= 1e-3;
    if (evidence.period_um > 0) {
      const double off = std::log(evidence.period_um / usual_sizes(screen.kind).period_um.y) / 0.15;
      weight *= 1e-3 + std::exp(-0.5 * off * off);
    }
    for (const PatternEvidence& pattern : evidence.patterns) {
      if (pattern.kind == screen.kind) weight *= std::exp(pattern.log_likelihood);
    }
    guesses.push_back({screen_names()[static_cast<std::size_t>(screen.kind)].name, weight});
    total += weight;
  }
  for (ScreenGuess& guess : guesses) guess.probability /= std::max(total, 1e-300);
  std::ranges::stable_sort(
      guesses, [](const auto& a, const auto& b) { return a.probability > b.probability; });
  return guesses;
}

}  // namespace reseau
