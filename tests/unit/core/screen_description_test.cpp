// The descriptions of screens, looked at point by point with code of the test's own.
#include "core/screen/screen_description.h"

#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

namespace reseau {
namespace {

double from_whole(double x) { return x - std::floor(x + 0.5); }

bool inside(const ScreenDescription& screen, const ScreenShape& shape, Vec2 s) {
  if (shape.kind == ScreenShape::Kind::kLine) {
    return std::abs(from_whole(dot(shape.bands[0].n, s - shape.center))) < shape.bands[0].half;
  }
  const Vec2 d{from_whole(s.x - shape.center.x), from_whole(s.y - shape.center.y)};
  if (shape.kind == ScreenShape::Kind::kDisc) {
    const double axes = screen.sizes.axes_deg * std::numbers::pi / 180;
    const Vec2 um{d.x * screen.sizes.period_um.x + d.y * screen.sizes.period_um.y * std::cos(axes),
                  d.y * screen.sizes.period_um.y * std::sin(axes)};
    return norm(um) < shape.radius_um;
  }
  for (const ScreenBand& band : shape.bands) {
    if (std::abs(dot(band.n, d)) >= band.half) return false;
  }
  return true;
}

int color_at(const ScreenDescription& screen, Vec2 s) {
  int color = screen.ground;
  for (const ScreenShape& shape : screen.shapes) {
    if (inside(screen, shape, s)) color = shape.color;
  }
  return color;
}

TEST(ScreenDescription, AreasAndMiddlesAreThoseOfTheShapes) {
  constexpr int kSide = 701;
  for (const ScreenName& kind : screen_names()) {
    const ScreenDescription screen = describe_screen(kind.kind);
    EXPECT_EQ(screen.name, kind.name);
    std::array<double, 3> counted{};
    for (int j = 0; j < kSide; ++j) {
      for (int i = 0; i < kSide; ++i) {
        const Vec2 s{(i + 0.37) / kSide, (j + 0.71) / kSide};
        counted[static_cast<std::size_t>(color_at(screen, s))] += 1.0 / (kSide * kSide);
      }
    }
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(counted[k], screen.areas[k], 3e-3) << screen.name << " " << k;
      EXPECT_EQ(color_at(screen, screen.middles[k]), static_cast<int>(k)) << screen.name;
    }
    EXPECT_NEAR(screen.areas[0] + screen.areas[1] + screen.areas[2], 1, 1e-12);
  }
}

TEST(ScreenDescription, NamesAreUniqueAndReadBack) {
  std::set<std::string> seen;
  for (const ScreenName& kind : screen_names()) {
    EXPECT_TRUE(seen.insert(std::string(kind.name)).second);
    EXPECT_EQ(screen_kind(kind.name), kind.kind);
  }
  EXPECT_EQ(screen_kind("spicer_dufay_blue"), ScreenKind::kSpicerDufayBlue);
  try {
    (void)screen_kind("agfacolor");
    FAIL();
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(), ::testing::HasSubstr("agfacolor"));
    EXPECT_THAT(e.what(), ::testing::HasSubstr("paget"));
  }
}

TEST(ScreenDescription, SizesOfTheMicrographsGiveTheirShares) {
  const auto areas = describe_screen(ScreenKind::kDufaycolorGawain).areas;
  EXPECT_NEAR(areas[0], 0.3745, 1e-12);
  EXPECT_NEAR(areas[1], 0.3058, 1e-12);
  EXPECT_NEAR(areas[2], 0.3197, 1e-4);
  EXPECT_NEAR(describe_screen(ScreenKind::kDufaycolor).areas[1], 28.9 / 49.9 * 22.7 / 49.6, 1e-12);
  EXPECT_NEAR(describe_screen(ScreenKind::kPaget).areas[2], 2 * 63.0 * 63 / (148.0 * 148), 1e-12);
}

}  // namespace
}  // namespace reseau
