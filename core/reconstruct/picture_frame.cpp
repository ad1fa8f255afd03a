#include "core/reconstruct/picture_frame.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "core/base/error.h"
#include "core/reconstruct/reconstruct.h"
#include "core/screen/screen_description.h"

namespace reseau {
namespace {

constexpr double kLeastScale = 1.0 / 64, kMostScale = 8;
constexpr double kMostSamples = 2147483647.0;
// The first printing of a Dufaycolor ran at about 23 degrees to the edge of the film, the second at
// about a right angle to it (Hubicka et al. 2025, arXiv:2501.06216).
constexpr double kDufayAngleDeg = 23;

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

// The smallest turn that gives the lines one of the angles that they have to the edges of a film,
// whichever edge and whichever side is up.
double turn_to_film_deg(const Registration& registration) {
  const ScreenKind kind = screen_kind(registration.screen);
  if (!is_dufaycolor(kind) && kind != ScreenKind::kSpicerDufayBlue &&
      kind != ScreenKind::kSpicerDufayGreen) {
    throw InputError("How a screen of this kind (" + registration.screen +
                     ") lies to the edge of its film is not known. Use --geometry screen or scan.");
  }
  double best = 90;
  for (const double edge :
       {kDufayAngleDeg, -kDufayAngleDeg, 90 - kDufayAngleDeg, kDufayAngleDeg - 90}) {
    const double turn = std::remainder(registration.angle_deg - edge, 180.0);
    if (std::abs(turn) < std::abs(best)) best = turn;
  }
  return best;
}

int whole_size(double size) { return std::max(1, static_cast<int>(std::lround(size))); }

}  // namespace

Geometry parse_geometry(std::string_view name) {
  if (name == "scan") return Geometry::kScan;
  if (name == "film") return Geometry::kFilm;
  if (name == "screen") return Geometry::kScreen;
  throw InputError("The geometry is scan, film or screen, not '" + std::string(name) + "'.");
}

PictureFrame::PictureFrame(const FrameChoice& choice, const Registration& registration,
                           int scan_width_px, int scan_height_px)
    : scale_(choice.scale) {
  if (!(choice.scale >= kLeastScale && choice.scale <= kMostScale)) {
    throw InputError("The scale must lie between 1/64 and 8; 1 gives the pixels of the scan.");
  }
  const PixelBounds all{0, 0, scan_width_px, scan_height_px};
  PixelBounds region = choice.region.value_or(all);
  region = {std::max(region.x0, 0), std::max(region.y0, 0), std::min(region.x1, all.x1),
            std::min(region.y1, all.y1)};
  if (region.width() < 1 || region.height() < 1) {
    throw InputError("The region lies outside the scan, which has " +
                     std::to_string(scan_width_px) + " x " + std::to_string(scan_height_px) +
                     " pixels.");
  }
  if (choice.geometry == Geometry::kScreen) {
    lay_on_screen(region, registration.map);
  } else {
    if (choice.geometry == Geometry::kFilm) turned_deg_ = turn_to_film_deg(registration);
    lay_flat(region, radians(turned_deg_));
  }
  const bool whole = region.x0 == 0 && region.y0 == 0 && region.x1 == all.x1 && region.y1 == all.y1;
  is_scan_ = choice.geometry == Geometry::kScan && choice.scale == 1 && whole;
  if (3.0 * width_px_ * height_px_ > kMostSamples) {
    throw InputError("The picture would be " + std::to_string(width_px_) + " x " +
                     std::to_string(height_px_) +
                     " pixels, more than can be written. Choose a smaller scale or region.");
  }
}

void PictureFrame::lay_flat(const PixelBounds& region, double turn_rad) {
  const double c = std::cos(turn_rad), s = std::sin(turn_rad);
  width_px_ = whole_size(scale_ * (std::abs(c) * region.width() + std::abs(s) * region.height()));
  height_px_ = whole_size(scale_ * (std::abs(s) * region.width() + std::abs(c) * region.height()));
  const double step = 1 / scale_;
  matrix_ = {step * c, step * s, -step * s, step * c};
  const Vec2 middle{0.5 * (region.x0 + region.x1 - 1), 0.5 * (region.y0 + region.y1 - 1)};
  offset_ = middle - matrix_ * Vec2{0.5 * (width_px_ - 1), 0.5 * (height_px_ - 1)};
}

void PictureFrame::lay_on_screen(const PixelBounds& region, const ScreenMap& map) {
  in_screen_ = true;
  // The axis of the réseau that is nearer to the rows of the scan becomes x; neither is turned
  // round, so that the picture lies as the scan does.
  const Mat2 scan_from_screen = map.linear().inverse();
  const Vec2 u{scan_from_screen.a, scan_from_screen.c}, v{scan_from_screen.b, scan_from_screen.d};
  const bool u_is_x = std::abs(u.x) / norm(u) >= std::abs(v.x) / norm(v);
  const Vec2 along_x = u_is_x ? u : v, along_y = u_is_x ? v : u;
  const double per_x = (along_x.x < 0 ? -1 : 1) / (norm(along_x) * scale_),
               per_y = (along_y.y < 0 ? -1 : 1) / (norm(along_y) * scale_);
  matrix_ = u_is_x ? Mat2{per_x, 0, 0, per_y} : Mat2{0, per_y, per_x, 0};
  const Mat2 picture_from_screen = matrix_.inverse();
  // The whole border, since it bends.
  Vec2 lowest{1e30, 1e30}, highest{-1e30, -1e30};
  const auto include = [&](double x, double y) {
    const Vec2 p = picture_from_screen * map.screen_from_scan({x, y});
    lowest = {std::min(lowest.x, p.x), std::min(lowest.y, p.y)};
    highest = {std::max(highest.x, p.x), std::max(highest.y, p.y)};
  };
  constexpr int kSteps = 64;
  for (int i = 0; i <= kSteps; ++i) {
    const double x = region.x0 - 0.5 + static_cast<double>(region.width()) * i / kSteps,
                 y = region.y0 - 0.5 + static_cast<double>(region.height()) * i / kSteps;
    include(x, region.y0 - 0.5);
    include(x, region.y1 - 0.5);
    include(region.x0 - 0.5, y);
    include(region.x1 - 0.5, y);
  }
  width_px_ = whole_size(highest.x - lowest.x);
  height_px_ = whole_size(highest.y - lowest.y);
  offset_ = matrix_ * (lowest + Vec2{0.5, 0.5});
}

Vec2 PictureFrame::scan_from_picture(const ScreenMap& map, Vec2 p) const {
  const Vec2 at = matrix_ * p + offset_;
  if (!in_screen_) return at;
  const Vec2 guess = map.linear().inverse() * (at - map.offset());
  return map.is_affine() ? guess : map.scan_from_screen(at, guess);
}

PixelBounds PictureFrame::scan_rect(const ScreenMap& map, const PixelBounds& picture) const {
  // A bend may bulge between the points of the border by less than this.
  constexpr int kSteps = 8, kRoom = 3;
  Vec2 lowest{1e30, 1e30}, highest{-1e30, -1e30};
  for (int j = 0; j <= kSteps; ++j) {
    for (int i = 0; i <= kSteps; ++i) {
      const Vec2 p = scan_from_picture(
          map, {picture.x0 - 0.5 + static_cast<double>(picture.width()) * i / kSteps,
                picture.y0 - 0.5 + static_cast<double>(picture.height()) * j / kSteps});
      lowest = {std::min(lowest.x, p.x), std::min(lowest.y, p.y)};
      highest = {std::max(highest.x, p.x), std::max(highest.y, p.y)};
    }
  }
  return {static_cast<int>(std::floor(lowest.x)) - kRoom,
          static_cast<int>(std::floor(lowest.y)) - kRoom,
          static_cast<int>(std::ceil(highest.x)) + kRoom + 1,
          static_cast<int>(std::ceil(highest.y)) + kRoom + 1};
}

}  // namespace reseau
