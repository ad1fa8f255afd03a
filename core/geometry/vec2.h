// Small fixed-size geometry in double precision. Transforms are named dst_from_src.
#pragma once

#include <cmath>

namespace reseau {

struct Vec2 {
  double x = 0, y = 0;
  friend Vec2 operator+(Vec2 a, Vec2 b) { return {a.x + b.x, a.y + b.y}; }
  friend Vec2 operator-(Vec2 a, Vec2 b) { return {a.x - b.x, a.y - b.y}; }
  friend Vec2 operator*(double s, Vec2 a) { return {s * a.x, s * a.y}; }
  bool operator==(const Vec2&) const = default;
};

inline double dot(Vec2 a, Vec2 b) { return a.x * b.x + a.y * b.y; }
inline double cross(Vec2 a, Vec2 b) { return a.x * b.y - a.y * b.x; }
inline double norm(Vec2 a) { return std::hypot(a.x, a.y); }

// Row-major 2x2 matrix: (a b; c d).
struct Mat2 {
  double a = 1, b = 0, c = 0, d = 1;
  friend Vec2 operator*(const Mat2& m, Vec2 v) {
    return {m.a * v.x + m.b * v.y, m.c * v.x + m.d * v.y};
  }
  friend Mat2 operator*(const Mat2& m, const Mat2& n) {
    return {m.a * n.a + m.b * n.c, m.a * n.b + m.b * n.d, m.c * n.a + m.d * n.c,
            m.c * n.b + m.d * n.d};
  }
  [[nodiscard]] double determinant() const { return a * d - b * c; }
  [[nodiscard]] Mat2 transposed() const { return {a, c, b, d}; }
  [[nodiscard]] Mat2 inverse() const {
    const double k = 1.0 / determinant();
    return {k * d, -k * b, -k * c, k * a};
  }
};

}  // namespace reseau
