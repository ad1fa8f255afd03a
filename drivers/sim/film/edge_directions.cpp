#include "drivers/sim/film/edge_directions.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/sim/film/placed_screen.h"
#include "drivers/sim/film/screen_of.h"

namespace reseau::sim {
namespace {

double off_axes_deg(double angle_deg) {
  const double rest = std::abs(std::remainder(angle_deg, 90.0));
  return std::min(rest, 90 - rest);
}

}  // namespace

Film::Edges edges_of(const FilmSpec& spec) {
  Film::Edges edges;
  if (spec.kind == FilmKind::kEmpty) return edges;
  // Small frames consist of borders; they do without the last bit of speed.
  constexpr double kSmallFrame = 3e5;
  const double frame_px = 1.0 * spec.frame.width_px * spec.frame.height_px * spec.frame.n_frames;
  if (frame_px < kSmallFrame) edges.fewest_cells = 8;
  edges.grainy = spec.emulsion.grain > 0;
  edges.spreads = spec.emulsion.spread_um > 0 || spec.emulsion.silver_spread_um > 0;
  if (spec.scene == SceneKind::kZone || spec.scene == SceneKind::kStar ||
      spec.scene == SceneKind::kImage) {
    edges.contrast = 1;
  }
  if (spec.scene == SceneKind::kEdges || spec.scene == SceneKind::kRazor ||
      spec.scene == SceneKind::kRandom) {
    edges.scene_off_axes_deg = off_axes_deg(spec.edge_angle_deg);
    edges.scene_contrast = 1;
  }
  // Steps from black to white, wherever they meet the elements' own.
  if (edges.scene_contrast > 0) edges.fewest_cells = 8;
  if (edges.spreads) edges.fewest_plain = 10;
  if (spec.kind != FilmKind::kDufay) return edges;
  // Light passes a clear gap undyed and exposes the film behind it; a dark one has two edges.
  if (spec.print.overlap_um < 0) {
    edges.contrast = 1;
    edges.fewest_cells = std::max(edges.fewest_cells, 8);
    if (frame_px < kSmallFrame) edges.fewest_plain = std::max(edges.fewest_plain, 10);
  }
  const ScreenGradient g = PlacedScreen(spec).scan_gradient();
  const ScreenDescription screen = describe_screen(spec.screen);
  // A tent is known across edges near the axes.
  constexpr double kNearAxes = 35;
  double farthest = 0;
  for (const ScreenShape& shape : screen.shapes) {
    if (shape.kind == ScreenShape::Kind::kDisc) {
      const double radius_px = shape.radius_um / spec.frame.pixel_um;
      edges.radius_px = edges.radius_px > 0 ? std::min(edges.radius_px, radius_px) : radius_px;
    }
    for (const ScreenBand& band : shape.bands) {
      const double x = band.n.x * g.u_x + band.n.y * g.v_x;
      const double y = band.n.x * g.u_y + band.n.y * g.v_y;
      const double off = off_axes_deg(std::atan2(y, x) * 180 / std::numbers::pi);
      edges.off_axes_deg = std::min(edges.off_axes_deg, off);
      farthest = std::max(farthest, off);
    }
  }
  // An edge that runs along the cells has the same error all along: frames of up to two megapixels
  // can afford finer ones.
  constexpr double kAlongAxes = 6, kCheapFrame = 2e6;
  if (edges.off_axes_deg < kAlongAxes && frame_px < kCheapFrame) {
    edges.fewest_cells = std::max(edges.fewest_cells, 8);
  }
  edges.tents = farthest < kNearAxes && edges.radius_px == 0 && spec.scene != SceneKind::kRazor &&
                spec.scene != SceneKind::kRandom;
  // Steps of the scene meet discs at any angle.
  if (edges.radius_px > 0 && edges.scene_contrast > 0) edges.fewest_cells = 24;
  if (edges.spreads) {
    // Silver changes within a cell together with the dyes above it: so many cells to a spread, more
    // where it is clipped behind gaps.
    const bool near_axes = edges.tents && edges.off_axes_deg < Film::Edges::kNearAxesDeg;
    const bool gaps = spec.print.overlap_um < 0;
    const double spread_px =
        std::hypot(spec.emulsion.spread_um, spec.emulsion.silver_spread_um) / spec.frame.pixel_um;
    const double wanted = gaps && near_axes ? 4.4 / std::pow(spread_px, 1.7)
                          : gaps            ? 4.5 / spread_px
                          : near_axes       ? 4.0 / spread_px
                                            : 2.5 / spread_px;
    int cells = 8;
    for (const int more : {10, 12, 16, 24, 32, 48}) {
      if (cells < wanted) cells = more;
    }
    edges.fewest_cells = std::max(edges.fewest_cells, cells);
    edges.fewest_plain = std::max(edges.fewest_plain, cells);
  }
  return edges;
}

}  // namespace reseau::sim
