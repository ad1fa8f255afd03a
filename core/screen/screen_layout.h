// How the elements of a family of screens lie, whatever their colours: what harmonics can tell
// apart. Which colour lies where, and so which screen it is, colours and the period say.
#pragma once

#include <array>
#include <complex>
#include <string_view>
#include <vector>

#include "core/geometry/vec2.h"
#include "core/screen/screen_description.h"
#include "core/screen/screen_tile.h"

namespace reseau {

enum class ScreenLayout {
  kLinesAndSquares,  // sites: the line at v = 0.5, squares at (0, 0) and at (0.5, 0)
  kTwoSites,         // sites: (0, 0), (0.5, 0.5), and what lies between
  kLines  // lines alone: sites at v = 1/6, 1/2, 5/6, each a third wide; nothing changes along u
};

// Of a screen that was made.
[[nodiscard]] ScreenLayout layout_of(ScreenKind kind);

struct LayoutSites {
  int special = 0;            // the site unlike the others: the line, or what lies between
  std::array<int, 2> pair{};  // the two that a shift exchanges
  Vec2 pair_shift;            // which shift [periods]
  bool square = false;        // the same when u and v are exchanged
};
[[nodiscard]] LayoutSites layout_sites(ScreenLayout layout);

// Real Fourier coefficients of the sites' masks: [site][mean, then kTileHarmonics]. Of lines alone
// the real parts: those are not even about one origin (see line_harmonic).
using SiteSeries = std::array<std::array<double, kTileAmplitudes>, 3>;
[[nodiscard]] const SiteSeries& site_series(ScreenLayout layout);

// Colours (0 red, 1 green, 2 blue) of the sites when the special one has this colour, in the order
// of the descriptions of screens.
[[nodiscard]] std::array<int, 3> site_colors(ScreenLayout layout, int special_color);

// Coefficient of exp(2 pi i h v) of the mask of one site of lines alone.
[[nodiscard]] std::complex<double> line_harmonic(int site, int h);
// How far true v lies beyond the v that harmonics 1 and 2 of R, G and B were measured in, modulo a
// third of a period: three lights behind lines of equal width make of the product of both
// harmonics a negative number at the true origin, whatever their colours.
[[nodiscard]] double line_origin(const std::array<std::complex<double>, 3>& first,
                                 const std::array<std::complex<double>, 3>& second);

// A screen by name, and how probable it is.
struct ScreenGuess {
  std::string_view name;
  double probability = 0;
};

// What the elements of a screen say of a scan, against those of the screen that fits best.
struct PatternEvidence {
  ScreenKind kind{};
  double log_likelihood = 0;  // of the best: 0
};

// What a search found.
struct ScreenEvidence {
  ScreenLayout layout = ScreenLayout::kLinesAndSquares;
  int special_color = 0;  // -1 = not known
  // Share of what alternates that the layout explains, and the most that another one does.
  double explained = 0, other_explained = 0;
  double period_um = 0;                     // 0 = unknown
  std::vector<PatternEvidence> patterns{};  // of some screens, or none
};

// Dufaycolors with elements of different sizes.
[[nodiscard]] std::vector<ScreenKind> dufaycolor_printings();
// The screens that were made in a layout with an odd colour; -1 = any.
[[nodiscard]] std::vector<ScreenKind> kinds_of(ScreenLayout layout, int special_color);

// The screens that were made, most probable first, all with the evidence for a réseau at all taken
// for granted; sums to one. Never empty.
[[nodiscard]] std::vector<ScreenGuess> name_screen(const ScreenEvidence& evidence);

}  // namespace reseau
