#include "core/screen/screen_map.h"

#include <cmath>

#include <gtest/gtest.h>

namespace reseau {
namespace {

ScreenMap bent_map() {
  constexpr int kColumns = 8, kRows = 9;
  std::vector<Vec2> coefficients;
  for (int j = 0; j < kRows; ++j) {
    for (int i = 0; i < kColumns; ++i)
      coefficients.push_back({0.3 * std::sin(i + 0.5 * j), 0.2 * std::cos(j)});
  }
  return {{0.12, 0.05, -0.05, 0.13}, {3, -4}, 40, kColumns, kRows, coefficients};
}

TEST(ScreenMap, AffineIsExact) {
  const ScreenMap map({0.12, 0.05, -0.05, 0.13}, {3, -4});
  const Vec2 s = map.screen_from_scan({10, 20});
  EXPECT_DOUBLE_EQ(s.x, 3 + 1.2 + 1.0);
  EXPECT_DOUBLE_EQ(s.y, -4 - 0.5 + 2.6);
  EXPECT_TRUE(map.is_affine());
}

TEST(ScreenMap, JacobianIsTheDerivative) {
  const ScreenMap map = bent_map();
  constexpr double kStep = 1e-5;
  for (const Vec2 p : {Vec2{33, 71}, {120.5, 10}, {199, 239}}) {
    const Mat2 j = map.jacobian(p);
    const Vec2 dx =
        map.screen_from_scan({p.x + kStep, p.y}) - map.screen_from_scan({p.x - kStep, p.y});
    const Vec2 dy =
        map.screen_from_scan({p.x, p.y + kStep}) - map.screen_from_scan({p.x, p.y - kStep});
    EXPECT_NEAR(j.a, dx.x / (2 * kStep), 1e-7);
    EXPECT_NEAR(j.c, dx.y / (2 * kStep), 1e-7);
    EXPECT_NEAR(j.b, dy.x / (2 * kStep), 1e-7);
    EXPECT_NEAR(j.d, dy.y / (2 * kStep), 1e-7);
  }
}

TEST(ScreenMap, ALineErrorMovesTheFilmUnderTheScan) {
  LineError line;
  line.axis = LineError::Axis::kLines;
  line.spacing_px = 16;
  for (int i = 0; i < 40; ++i) line.coefficients.push_back({0.1 * std::sin(i), std::cos(2 * i)});
  const ScreenMap film = bent_map(), seen = film.with_line_error(line);
  EXPECT_FALSE(seen.is_affine());
  const Vec2 p{123.4, 210.7};
  const Vec2 expected = film.screen_from_scan(p + line.at(p));
  EXPECT_NEAR(norm(seen.screen_from_scan(p) - expected), 0, 1e-12);
  // The derivative, along the motion as well.
  constexpr double kStep = 1e-5;
  const Vec2 slope = (0.5 / kStep) * (seen.screen_from_scan({p.x, p.y + kStep}) -
                                      seen.screen_from_scan({p.x, p.y - kStep}));
  const Mat2 j = seen.jacobian(p);
  EXPECT_NEAR(j.b, slope.x, 1e-7);
  EXPECT_NEAR(j.d, slope.y, 1e-7);
}

TEST(ScreenMap, InverseComesBack) {
  const ScreenMap map = bent_map();
  const Vec2 p{87.25, 140.75};
  const Vec2 back = map.scan_from_screen(map.screen_from_scan(p), {95, 130});
  EXPECT_NEAR(back.x, p.x, 1e-7);
  EXPECT_NEAR(back.y, p.y, 1e-7);
}

TEST(ScreenMap, DisplacementDoesNotGrowOutsideTheFrame) {
  const ScreenMap map = bent_map();
  const ScreenMap plain(map.linear(), map.offset());
  const Vec2 rim = map.screen_from_scan({200, 100}) - plain.screen_from_scan({200, 100});
  const Vec2 far = map.screen_from_scan({5000, 100}) - plain.screen_from_scan({5000, 100});
  EXPECT_NEAR(rim.x, far.x, 1e-12);
  EXPECT_NEAR(rim.y, far.y, 1e-12);
}

}  // namespace
}  // namespace reseau
