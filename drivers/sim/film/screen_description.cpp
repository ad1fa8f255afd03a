#include "drivers/sim/film/screen_description.h"

#include <cmath>
#include <cstddef>
#include <numbers>

namespace reseau::sim {
namespace {

constexpr int kRed = 0, kGreen = 1, kBlue = 2;
using Kind = ScreenShape::Kind;

// Lines at v = 0.5 and between them two kinds of squares: the first at u = 0, the second elsewhere.
struct LineRoles {
  int line, first, second;
};

ScreenDescription lines_and_squares(std::string_view name, LineRoles dyes, const ScreenSpec& spec) {
  ScreenDescription screen{name, dyes.second, {}, {}, {}};
  screen.shapes.push_back({Kind::kLine, dyes.first, 0, 0, {{1, 0, spec.green_fraction / 2}}, 0});
  screen.shapes.push_back(
      {Kind::kLine, dyes.line, 0, 0.5, {{0, 1, spec.red_fraction / 2}}, 0, true});
  const double between = 1 - spec.red_fraction;
  const auto at = [&](int dye) -> double& { return screen.areas[static_cast<std::size_t>(dye)]; };
  screen.middles[static_cast<std::size_t>(dyes.line)] = {0, 0.5};
  screen.middles[static_cast<std::size_t>(dyes.second)] = {0.5, 0};  // the first is at (0, 0)
  at(dyes.line) = spec.red_fraction;
  at(dyes.first) = between * spec.green_fraction;
  at(dyes.second) = 1 - spec.red_fraction - at(dyes.first);
  return screen;
}

// Lines of three colours side by side, green in the middle of red and blue.
ScreenDescription three_lines(std::string_view name) {
  ScreenDescription screen{
      name, kBlue, {}, {1.0 / 3, 1.0 / 3, 1.0 / 3}, {{{0, 1.0 / 6}, {0, 0.5}, {0, 5.0 / 6}}}};
  screen.shapes.push_back({Kind::kLine, kRed, 0, 0.5 - 1.0 / 3, {{0, 1, 1.0 / 6}}, 0});
  screen.shapes.push_back({Kind::kLine, kGreen, 0, 0.5, {{0, 1, 1.0 / 6}}, 0});
  return screen;
}

// Squares of 85 um (red, green, corner to corner) and 63 um (blue) after Wall 1925, so that 148 um
// hold one of each per direction. Where the corners of red and green would overlap, the border runs
// along the diagonal.
ScreenDescription paget(std::string_view name) {
  constexpr double kLarge = 85.0 / 148, kSmall = 63.0 / 148;
  ScreenDescription screen{name, kBlue, {}, {}, {{{0, 0}, {0.5, 0.5}, {0.5, 0}}}};
  const std::vector<ShapeBand> square{
      {1, 0, kLarge / 2}, {0, 1, kLarge / 2}, {1, 1, 0.5}, {1, -1, 0.5}};
  screen.shapes.push_back({Kind::kPolygon, kRed, 0, 0, square, 0});
  screen.shapes.push_back({Kind::kPolygon, kGreen, 0.5, 0.5, square, 0});
  screen.areas[kBlue] = 2 * kSmall * kSmall;
  screen.areas[kRed] = screen.areas[kGreen] = (1 - screen.areas[kBlue]) / 2;
  return screen;
}

// A red and a green disc of equal size per cell; 31.8 % each, which is what Color-Screen uses.
ScreenDescription thames(const ScreenSpec& spec) {
  constexpr double kArea = 0.318;
  ScreenDescription screen{
      "thames", kBlue, {}, {kArea, kArea, 1 - 2 * kArea}, {{{0, 0}, {0.5, 0.5}, {0.5, 0}}}};
  const double cell =
      spec.period_v_um / spec.period_u_um * std::sin(spec.axes_deg * std::numbers::pi / 180);
  const double radius = std::sqrt(kArea * cell / std::numbers::pi);
  screen.shapes.push_back({Kind::kDisc, kRed, 0, 0, {}, radius});
  screen.shapes.push_back({Kind::kDisc, kGreen, 0.5, 0.5, {}, radius});
  return screen;
}

}  // namespace

ScreenDescription describe_screen(const ScreenSpec& spec) {
  switch (spec.kind) {
    case ScreenKind::kDufay:
      break;
    case ScreenKind::kSpicerDufayBlue:
      return lines_and_squares("spicer_dufay_blue", {kBlue, kGreen, kRed}, spec);
    case ScreenKind::kSpicerDufayGreen:
      return lines_and_squares("spicer_dufay_green", {kGreen, kBlue, kRed}, spec);
    case ScreenKind::kDioptichrome:
      return lines_and_squares("dioptichrome", {kGreen, kRed, kBlue}, spec);
    case ScreenKind::kImprovedDioptichrome:
      return lines_and_squares("improved_dioptichrome", {kBlue, kRed, kGreen}, spec);
    case ScreenKind::kOmnicolore:
      return lines_and_squares("omnicolore", {kBlue, kRed, kGreen}, spec);
    case ScreenKind::kPaget:
      return paget("paget");
    case ScreenKind::kFinlay:
      return paget("finlay");
    case ScreenKind::kThames:
      return thames(spec);
    case ScreenKind::kJoly:
      return three_lines("joly");
    case ScreenKind::kWarnerPowrie:
      return three_lines("warner_powrie");
  }
  return lines_and_squares("dufaycolor", {kRed, kGreen, kBlue}, spec);
}

void set_screen_kind(ScreenSpec& screen, ScreenKind kind) {
  screen.kind = kind;
  const ScreenSpec dufay;
  screen.red_fraction = dufay.red_fraction;
  screen.green_fraction = dufay.green_fraction;
  screen.axes_deg = 90;
  const auto periods = [&](double u_um, double v_um) {
    screen.period_u_um = u_um;
    screen.period_v_um = v_um;
  };
  const auto shares = [&](double line, double first) {
    screen.red_fraction = line;
    screen.green_fraction = first / (1 - line);
  };
  switch (kind) {
    case ScreenKind::kDufay:
    case ScreenKind::kSpicerDufayBlue:
    case ScreenKind::kSpicerDufayGreen:
      periods(dufay.period_u_um, dufay.period_v_um);
      screen.axes_deg = dufay.axes_deg;
      return;
    case ScreenKind::kDioptichrome:
      periods(80, 80);
      return shares(0.50, 0.25);
    case ScreenKind::kImprovedDioptichrome:
      periods(80, 80);
      return shares(0.34, 0.33);
    case ScreenKind::kOmnicolore:
      periods(80, 80);
      return shares(0.31, 0.3105);
    case ScreenKind::kPaget:
      return periods(148, 148);
    case ScreenKind::kFinlay:
    case ScreenKind::kThames:
      return periods(100, 100);
    case ScreenKind::kJoly:
      return periods(300, 300);
    case ScreenKind::kWarnerPowrie:
      return periods(127, 127);
  }
}

}  // namespace reseau::sim
