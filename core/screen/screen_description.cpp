#include "core/screen/screen_description.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>

#include "core/base/check.h"
#include "core/base/error.h"

namespace reseau {
namespace {

using ShapeKind = ScreenShape::Kind;

// Lines at v = 0.5 and between them two kinds of squares.
struct LineRoles {
  int line, first, second;
};

// What the ground shows where the first kind of square was not printed; the lines lie across both.
void lines_and_squares(ScreenDescription& screen, LineRoles colors) {
  const double width = screen.sizes.line_width, length = screen.sizes.first_length;
  CHECK(width > 0 && width < 1 && length > 0 && length < 1);
  screen.ground = colors.second;
  screen.shapes.push_back(
      {ShapeKind::kLine, colors.first, {0, 0}, {{{1, 0}, length / 2}}, 0, false});
  screen.shapes.push_back(
      {ShapeKind::kLine, colors.line, {0, 0.5}, {{{0, 1}, width / 2}}, 0, true});
  const auto index = [](int color) { return static_cast<std::size_t>(color); };
  screen.middles[index(colors.line)] = {0, 0.5};
  screen.middles[index(colors.second)] = {0.5, 0};  // the first kind is at (0, 0)
  screen.areas[index(colors.line)] = width;
  screen.areas[index(colors.first)] = (1 - width) * length;
  screen.areas[index(colors.second)] = (1 - width) * (1 - length);
}

// Lines of three colours side by side, green in the middle of red and blue.
void three_lines(ScreenDescription& screen) {
  constexpr double kThird = 1.0 / 3;
  screen.areas = {kThird, kThird, kThird};
  screen.middles = {{{0, kThird / 2}, {0, 0.5}, {0, 1 - kThird / 2}}};
  const std::vector<ScreenBand> band{{{0, 1}, kThird / 2}};
  screen.shapes.push_back({ShapeKind::kLine, kRedElement, {0, kThird / 2}, band, 0, false});
  screen.shapes.push_back({ShapeKind::kLine, kGreenElement, {0, 0.5}, band, 0, false});
}

// Squares of 85 um (red, green, corner to corner) and 63 um (blue) after Wall 1925, so that 148 um
// hold one of each per direction. Where the corners of red and green would overlap, the border runs
// along the diagonal.
void two_squares(ScreenDescription& screen) {
  constexpr double kLarge = 85.0 / 148, kSmall = 63.0 / 148;
  const std::vector<ScreenBand> square{
      {{1, 0}, kLarge / 2}, {{0, 1}, kLarge / 2}, {{1, 1}, 0.5}, {{1, -1}, 0.5}};
  screen.middles = {{{0, 0}, {0.5, 0.5}, {0.5, 0}}};
  screen.shapes.push_back({ShapeKind::kPolygon, kRedElement, {0, 0}, square, 0, false});
  screen.shapes.push_back({ShapeKind::kPolygon, kGreenElement, {0.5, 0.5}, square, 0, false});
  screen.areas[kBlueElement] = 2 * kSmall * kSmall;
  screen.areas[kRedElement] = screen.areas[kGreenElement] = (1 - screen.areas[kBlueElement]) / 2;
}

// A red and a green disc of equal size per cell; 31.8 % each, which is what Color-Screen uses.
void discs(ScreenDescription& screen) {
  constexpr double kArea = 0.318;
  const ScreenSizes& sizes = screen.sizes;
  const double cell_um2 =
      sizes.period_um.x * sizes.period_um.y * std::sin(sizes.axes_deg * std::numbers::pi / 180);
  const double radius_um = std::sqrt(kArea * cell_um2 / std::numbers::pi);
  screen.middles = {{{0, 0}, {0.5, 0.5}, {0.5, 0}}};
  screen.shapes.push_back({ShapeKind::kDisc, kRedElement, {0, 0}, {}, radius_um, false});
  screen.shapes.push_back({ShapeKind::kDisc, kGreenElement, {0.5, 0.5}, {}, radius_um, false});
  screen.areas = {kArea, kArea, 1 - 2 * kArea};
}

// Sizes of a screen of lines and squares from the shares of its area.
ScreenSizes from_shares(Vec2 period_um, double axes_deg, double line, double first) {
  return {period_um, axes_deg, line, first / (1 - line)};
}

}  // namespace

const std::vector<ScreenName>& screen_names() {
  static const std::vector<ScreenName> names{
      {ScreenKind::kDufaycolor, "dufaycolor"},
      {ScreenKind::kDufaycolorGawain, "dufaycolor-gawain"},
      {ScreenKind::kDufaycolorPenichon, "dufaycolor-penichon"},
      {ScreenKind::kDufaycolorClyneColor, "dufaycolor-cornwell-clyne-color"},
      {ScreenKind::kDufaycolorClyneBw, "dufaycolor-cornwell-clyne-bw"},
      {ScreenKind::kSpicerDufayBlue, "spicer-dufay-blue"},
      {ScreenKind::kSpicerDufayGreen, "spicer-dufay-green"},
      {ScreenKind::kDioptichrome, "dioptichrome-b"},
      {ScreenKind::kImprovedDioptichrome, "improved-dioptichrome-b"},
      {ScreenKind::kOmnicolore, "omnicolore"},
      {ScreenKind::kPaget, "paget"},
      {ScreenKind::kFinlay, "finlay"},
      {ScreenKind::kThames, "thames"},
      {ScreenKind::kJoly, "joly"},
      {ScreenKind::kWarnerPowrie, "warner-powrie"},
  };
  return names;
}

ScreenKind screen_kind(std::string_view name) {
  std::string word(name), known;
  std::ranges::replace(word, '_', '-');
  for (const ScreenName& screen : screen_names()) {
    if (screen.name == word) return screen.kind;
    known.append(known.empty() ? "" : ", ").append(screen.name);
  }
  throw InputError("There is no screen \"" + std::string(name) + "\"; known are " + known + ".");
}

ScreenSizes usual_sizes(ScreenKind kind) {
  // Dufaycolor and Spicer-Dufay (sizes assumed): micrograph, Hubicka et al. 2025
  // (arXiv:2501.06216). The order of Spicer-Dufay: the same, note 3.
  constexpr Vec2 kDufay{49.6, 49.9};
  constexpr double kDufayAxes = 89.4, kDufayLine = 21.0 / 49.9, kDufayFirst = 22.7 / 49.6;
  switch (kind) {
    case ScreenKind::kDufaycolor:
      break;
    // The square that is the smaller in a Dufaycolor is the second here: red is the first kind
    // wherever the lines are not red.
    case ScreenKind::kSpicerDufayBlue:
    case ScreenKind::kSpicerDufayGreen:
      return {kDufay, kDufayAxes, kDufayLine, 1 - kDufayFirst};
    // Shares on other micrographs, measured by Color-Screen; periods as above.
    case ScreenKind::kDufaycolorGawain:
      return from_shares(kDufay, kDufayAxes, 0.3745, 0.3058);
    case ScreenKind::kDufaycolorPenichon:
      return from_shares(kDufay, kDufayAxes, 0.4265, 0.3044);
    case ScreenKind::kDufaycolorClyneColor:
      return from_shares(kDufay, kDufayAxes, 0.371, 0.246);
    case ScreenKind::kDufaycolorClyneBw:
      return from_shares(kDufay, kDufayAxes, 0.325, 0.286);
    // Shares: Color-Screen. Periods of 80 um assumed.
    case ScreenKind::kDioptichrome:
      return from_shares({80, 80}, 90, 0.50, 0.25);
    case ScreenKind::kImprovedDioptichrome:
      return from_shares({80, 80}, 90, 0.34, 0.33);
    case ScreenKind::kOmnicolore:
      return from_shares({80, 80}, 90, 0.31, 0.3105);
    case ScreenKind::kPaget:  // Wall 1925
      return {{148, 148}};
    case ScreenKind::kFinlay:  // assumed; smaller than Paget (Penichon 2013)
    case ScreenKind::kThames:  // assumed
      return {{100, 100}};
    case ScreenKind::kJoly:  // 0.1 mm a line: Barker et al. 2022
      return {{300, 300}};
    case ScreenKind::kWarnerPowrie:  // assumed
      return {{127, 127}};
  }
  return {kDufay, kDufayAxes, kDufayLine, kDufayFirst};
}

ScreenDescription describe_screen(ScreenKind kind, const ScreenSizes& sizes) {
  ScreenDescription screen;
  screen.kind = kind;
  screen.name = screen_names()[static_cast<std::size_t>(kind)].name;
  screen.sizes = sizes;
  switch (kind) {
    case ScreenKind::kDufaycolor:
    case ScreenKind::kDufaycolorGawain:
    case ScreenKind::kDufaycolorPenichon:
    case ScreenKind::kDufaycolorClyneColor:
    case ScreenKind::kDufaycolorClyneBw:
      lines_and_squares(screen, {kRedElement, kGreenElement, kBlueElement});
      break;
    case ScreenKind::kSpicerDufayBlue:
      lines_and_squares(screen, {kBlueElement, kRedElement, kGreenElement});
      break;
    case ScreenKind::kSpicerDufayGreen:
      lines_and_squares(screen, {kGreenElement, kRedElement, kBlueElement});
      break;
    case ScreenKind::kDioptichrome:
      lines_and_squares(screen, {kGreenElement, kRedElement, kBlueElement});
      break;
    case ScreenKind::kImprovedDioptichrome:
    case ScreenKind::kOmnicolore:
      lines_and_squares(screen, {kBlueElement, kRedElement, kGreenElement});
      break;
    case ScreenKind::kPaget:
    case ScreenKind::kFinlay:
      two_squares(screen);
      break;
    case ScreenKind::kThames:
      discs(screen);
      break;
    case ScreenKind::kJoly:
    case ScreenKind::kWarnerPowrie:
      three_lines(screen);
      break;
  }
  return screen;
}

}  // namespace reseau
