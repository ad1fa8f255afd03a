#include "core/color/gamut.h"

#include <cmath>
#include <vector>

#include "core/color/delta_e.h"
#include "core/color/rgb_space.h"
#include "core/geometry/vec2.h"

namespace reseau {
namespace {

using Polygon = std::vector<Vec2>;

Polygon triangle_of(const Matrix3& xyz_from_rgb) {
  Polygon triangle;
  for (int i = 0; i < 3; ++i) {
    const Chromaticity c = chromaticity_of(column(xyz_from_rgb, i));
    triangle.push_back({c[0], c[1]});
  }
  return triangle;
}

double signed_area(const Polygon& polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    twice += cross(polygon[i], polygon[(i + 1) % polygon.size()]);
  }
  return twice / 2;
}

// Sutherland and Hodgman 1974: what of `subject` lies inside the convex `clip`.
Polygon intersection(Polygon subject, const Polygon& clip) {
  const double turn = signed_area(clip) < 0 ? -1 : 1;
  for (std::size_t i = 0; i < clip.size(); ++i) {
    const Vec2 a = clip[i], edge = clip[(i + 1) % clip.size()] - a;
    const auto side = [&](const Vec2& p) { return turn * cross(edge, p - a); };
    Polygon kept;
    for (std::size_t k = 0; k < subject.size(); ++k) {
      const Vec2 p = subject[k], q = subject[(k + 1) % subject.size()];
      const double sp = side(p), sq = side(q);
      if (sp >= 0) kept.push_back(p);
      if ((sp >= 0) != (sq >= 0)) kept.push_back(p + (sp / (sp - sq)) * (q - p));
    }
    subject = kept;
  }
  return subject;
}

// By the divergence theorem over the six faces of the cube of intensities; even steps of their cube
// root are about even steps of lightness.
double lab_volume(const Matrix3& xyz_from_rgb) {
  constexpr int kSteps = 40;
  const Xyz white = white_of(Illuminant::kD65);
  const auto at = [&](std::size_t face_axis, double face, double s, double t) {
    Vector3 rgb{};
    rgb[face_axis] = face;
    rgb[(face_axis + 1) % 3] = s * s * s;
    rgb[(face_axis + 2) % 3] = t * t * t;
    return lab_from_xyz(multiply(xyz_from_rgb, rgb), white);
  };
  const auto tetrahedron = [](const Lab& a, const Lab& b, const Lab& c) {
    return (a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
            a[2] * (b[0] * c[1] - b[1] * c[0])) /
           6;
  };
  double volume = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const double face : {0.0, 1.0}) {
      const double outward = face > 0 ? 1 : -1;
      for (int i = 0; i < kSteps; ++i) {
        for (int k = 0; k < kSteps; ++k) {
          const double s0 = i / double{kSteps}, s1 = (i + 1) / double{kSteps};
          const double t0 = k / double{kSteps}, t1 = (k + 1) / double{kSteps};
          const Lab a = at(axis, face, s0, t0), b = at(axis, face, s1, t0),
                    c = at(axis, face, s1, t1), d = at(axis, face, s0, t1);
          volume += outward * (tetrahedron(a, b, c) + tetrahedron(a, c, d));
        }
      }
    }
  }
  return std::abs(volume);
}

}  // namespace

GamutFigures gamut_of(const Matrix3& xyz) {
  static const Matrix3 srgb = inverse(srgb_from_xyz_d65());
  static const double srgb_volume = lab_volume(srgb);
  const Polygon own = triangle_of(xyz), reference = triangle_of(srgb);
  const double srgb_area = std::abs(signed_area(reference));
  GamutFigures figures;
  figures.area_xy = std::abs(signed_area(own));
  if (!(figures.area_xy > 1e-12)) return {};
  figures.area_of_srgb = figures.area_xy / srgb_area;
  figures.coverage = std::abs(signed_area(intersection(reference, own))) / srgb_area;
  figures.volume = lab_volume(xyz);
  figures.volume_of_srgb = figures.volume / srgb_volume;
  return figures;
}

}  // namespace reseau
