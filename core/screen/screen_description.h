// The screens that were made, as data: a lattice and, in the order of printing, shapes of one
// colour each on a ground. Who samples, blurs or looks for them does so in code of their own.
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "core/geometry/vec2.h"

namespace reseau {

enum class ScreenKind {
  kDufaycolor,            // red lines (printed last), green and blue squares between
  kDufaycolorGawain,      // the same with the sizes of other micrographs
  kDufaycolorPenichon,    //
  kDufaycolorClyneColor,  //
  kDufaycolorClyneBw,     //
  kSpicerDufayBlue,       // blue lines last, red and green squares
  kSpicerDufayGreen,      // green lines last, red and blue squares
  kDioptichrome,          // green lines, red and blue squares
  kImprovedDioptichrome,  // blue lines, red and green squares
  kOmnicolore,            // the same
  kPaget,                 // squares of two sizes
  kFinlay,
  kThames,  // red and green discs on blue
  kJoly,    // lines of three colours
  kWarnerPowrie
};

// Colours of elements, as everything of a screen counts them.
inline constexpr int kRedElement = 0, kGreenElement = 1, kBlueElement = 2;

// |n . (s - center)| < half for screen coordinates s [periods]. A line has one band with whole n
// and repeats with it; a polygon is what two or more bands have in common.
struct ScreenBand {
  Vec2 n;
  double half = 0;
};

// Polygons and discs repeat once per cell of the lattice.
struct ScreenShape {
  enum class Kind { kLine, kPolygon, kDisc };
  Kind kind = Kind::kLine;
  int color = 0;  // 0 red, 1 green, 2 blue
  Vec2 center;    // [periods]
  std::vector<ScreenBand> bands;
  double radius_um = 0;  // of a disc
  // Printed across what was printed before, as the last lines of a Dufaycolor; otherwise it lies
  // beside the other shapes, on the ground, and may touch them.
  bool across = false;
};

// What differs from one printing to the next.
struct ScreenSizes {
  Vec2 period_um;           // lengths of the lattice vectors
  double axes_deg = 90;     // between them
  double line_width = 0;    // of screens of lines and squares: the line [periods of v]
  double first_length = 0;  // and the first kind of square along it [periods of u]
  bool operator==(const ScreenSizes&) const = default;
};

// Screen coordinates (u, v) in periods: of screens of lines and squares u runs along the lines,
// which lie at v = 0.5; the first kind of square is at (0, 0), the second at (0.5, 0).
struct ScreenDescription {
  ScreenKind kind = ScreenKind::kDufaycolor;
  std::string_view name;  // "dufaycolor", "spicer-dufay-blue", "paget" …, as in screen_areas()
  ScreenSizes sizes;
  int ground = 2;  // colour of what no shape covers
  std::vector<ScreenShape> shapes;
  std::array<double, 3> areas{};  // fractions of red, green, blue; closed form of the layout
  std::array<Vec2, 3> middles{};  // of one red, green and blue element of a period
};

// All kinds with their names, in the order of the enumeration.
struct ScreenName {
  ScreenKind kind;
  std::string_view name;
};
[[nodiscard]] const std::vector<ScreenName>& screen_names();
// Red lines with green and blue squares between, whatever the sizes.
[[nodiscard]] inline bool is_dufaycolor(ScreenKind kind) {
  return kind <= ScreenKind::kDufaycolorClyneBw;
}
// Throws InputError for an unknown name, listing those there are. '_' counts as '-'.
[[nodiscard]] ScreenKind screen_kind(std::string_view name);

// As printed, by the sources in screen_description.cpp.
[[nodiscard]] ScreenSizes usual_sizes(ScreenKind kind);
[[nodiscard]] ScreenDescription describe_screen(ScreenKind kind, const ScreenSizes& sizes);
[[nodiscard]] inline ScreenDescription describe_screen(ScreenKind kind) {
  return describe_screen(kind, usual_sizes(kind));
}

}  // namespace reseau
