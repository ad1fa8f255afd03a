// Which part of a scan a picture shows, how large, and how it lies.
#pragma once

#include <optional>
#include <string_view>

#include "core/geometry/pixel_bounds.h"
#include "core/geometry/vec2.h"
#include "core/screen/screen_map.h"

namespace reseau {

struct Registration;

enum class Geometry {
  kScan,   // pixels lie as in the scan
  kFilm,   // turned until the edges of the film run along those of the picture
  kScreen  // the axes of the réseau are those of the picture; what bends in the scan is straight
};
// "scan", "film" or "screen"; InputError for anything else.
[[nodiscard]] Geometry parse_geometry(std::string_view name);

struct FrameChoice {
  Geometry geometry = Geometry::kScan;
  double scale = 1;                   // pixels of the picture per pixel of the scan, 1/64..8
  std::optional<PixelBounds> region;  // of the scan; absent: all of it
};

// Immutable, thread-safe.
class PictureFrame {
 public:
  // Throws InputError where the choice cannot be met: a region outside the scan, a scale out of
  // range or a picture of more than 2^31 samples, a film whose réseau has no known angle to its
  // edge.
  PictureFrame(const FrameChoice& choice, const Registration& registration, int scan_width_px,
               int scan_height_px);

  [[nodiscard]] int width_px() const { return width_px_; }
  [[nodiscard]] int height_px() const { return height_px_; }
  // Pixel (x, y) of the picture is pixel (x, y) of the scan, for all of it.
  [[nodiscard]] bool is_scan() const { return is_scan_; }
  // Rows and columns of the picture are rows and columns of the scan, only wider or narrower.
  [[nodiscard]] bool is_straight() const { return !in_screen_ && matrix_.b == 0 && matrix_.c == 0; }
  [[nodiscard]] double scale() const { return scale_; }
  // How far the picture is turned against the scan (kFilm) [degree].
  [[nodiscard]] double turned_deg() const { return turned_deg_; }
  [[nodiscard]] Vec2 scan_from_picture(const ScreenMap& map, Vec2 p) const;
  // The scan pixels within which a rectangle of the picture lies; may reach outside the scan.
  [[nodiscard]] PixelBounds scan_rect(const ScreenMap& map, const PixelBounds& picture) const;

 private:
  void lay_flat(const PixelBounds& region, double turn_rad);
  void lay_on_screen(const PixelBounds& region, const ScreenMap& map);

  bool is_scan_ = true, in_screen_ = false;
  int width_px_ = 0, height_px_ = 0;
  double scale_ = 1, turned_deg_ = 0;
  Mat2 matrix_;  // from picture pixels to the scan, or in_screen_ to screen coordinates
  Vec2 offset_;
};

}  // namespace reseau
