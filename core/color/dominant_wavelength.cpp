#include "core/color/dominant_wavelength.h"

#include <algorithm>

#include "core/geometry/vec2.h"

namespace reseau {
namespace {

Vec2 locus_point(const Observer& observer, int index) {
  const auto i = static_cast<std::size_t>(index);
  const Chromaticity c = chromaticity_of({observer.xbar[i], observer.ybar[i], observer.zbar[i]});
  return {c[0], c[1]};
}

}  // namespace

std::optional<double> dominant_wavelength_nm(const Chromaticity& color, const Chromaticity& white,
                                             const Observer& observer) {
  const Vec2 origin{white[0], white[1]};
  const Vec2 ray = Vec2{color[0], color[1]} - origin;
  double farthest = 0;
  std::optional<double> found_nm;
  for (int i = 0; i + 1 < observer.grid.count; ++i) {
    const Vec2 start = locus_point(observer, i);
    const Vec2 side = locus_point(observer, i + 1) - start;
    const double parallel = cross(ray, side);
    if (parallel == 0) {
      continue;
    }
    const double along_ray = cross(start - origin, side) / parallel;
    const double along_side = cross(start - origin, ray) / parallel;
    // The locus folds back on itself at its ends; the outermost crossing is the one meant.
    if (along_ray > farthest && along_side >= 0 && along_side <= 1) {
      farthest = along_ray;
      found_nm = observer.grid.wavelength_nm(i) + along_side * observer.grid.step_nm;
    }
  }
  return found_nm;
}

bool is_color_of_light(const Chromaticity& color, const Observer& observer, double tolerance) {
  const Vec2 p{color[0], color[1]};
  bool inside = false;
  double nearest = 1e9;
  for (int i = 0; i < observer.grid.count; ++i) {
    const Vec2 a = locus_point(observer, i),
               b = locus_point(observer, i + 1 < observer.grid.count ? i + 1 : 0), side = b - a;
    if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / side.y * side.x) inside = !inside;
    const double length2 = dot(side, side);
    const double t = length2 > 0 ? std::clamp(dot(p - a, side) / length2, 0.0, 1.0) : 0;
    nearest = std::min(nearest, norm(p - a - t * side));
  }
  return inside || nearest <= tolerance;
}

}  // namespace reseau
