#include "core/reconstruct/picture_frame.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/reconstruct/reconstruct.h"

namespace reseau {
namespace {

constexpr int kWidth = 400, kHeight = 300;

// A Dufaycolor whose lines lie at this angle from the y axis, eight pixels to the period.
Registration found(double angle_deg) {
  const double a = angle_deg * std::numbers::pi / 180;
  Registration r;
  r.found = true;
  r.screen = "dufaycolor";
  r.angle_deg = angle_deg;
  // v grows across the lines, u along them.
  r.map = ScreenMap({std::sin(a) / 8, std::cos(a) / 8, std::cos(a) / 8, -std::sin(a) / 8}, {3, -2});
  return r;
}

void expect_near(Vec2 a, Vec2 b) {
  EXPECT_NEAR(a.x, b.x, 1e-9);
  EXPECT_NEAR(a.y, b.y, 1e-9);
}

TEST(PictureFrame, TheScanAsItLies) {
  const Registration r = found(10);
  const PictureFrame frame({}, r, kWidth, kHeight);
  EXPECT_TRUE(frame.is_scan());
  EXPECT_EQ(frame.width_px(), kWidth);
  expect_near(frame.scan_from_picture(r.map, {7, 9}), {7, 9});
}

// Outer borders meet, so that pixel centres shift by half the difference of the pixel sizes.
TEST(PictureFrame, ARegionMadeSmaller) {
  const Registration r = found(10);
  const PictureFrame frame({Geometry::kScan, 0.25, PixelBounds{40, 20, 140, 100}}, r, kWidth,
                           kHeight);
  EXPECT_FALSE(frame.is_scan());
  EXPECT_EQ(frame.width_px(), 25);
  EXPECT_EQ(frame.height_px(), 20);
  expect_near(frame.scan_from_picture(r.map, {-0.5, -0.5}), {39.5, 19.5});
  expect_near(frame.scan_from_picture(r.map, {24.5, 19.5}), {139.5, 99.5});
}

TEST(PictureFrame, ARegionThatReachesOutIsCut) {
  const PictureFrame frame({Geometry::kScan, 1, PixelBounds{300, -50, 900, 50}}, found(0), kWidth,
                           kHeight);
  EXPECT_EQ(frame.width_px(), 100);
  EXPECT_EQ(frame.height_px(), 50);
}

// Whatever is up and whichever way round the film lies: the smallest turn to a known angle.
TEST(PictureFrame, FilmIsTurnedUpright) {
  struct Case {
    double angle_deg, turn_deg;
  };
  for (const Case& c :
       {Case{23, 0}, {21.5, -1.5}, {-23.75, -0.75}, {68, 1}, {-64, 3}, {157, 0}, {115, 2}}) {
    const Registration r = found(c.angle_deg);
    const PictureFrame frame({Geometry::kFilm, 1, std::nullopt}, r, kWidth, kHeight);
    EXPECT_NEAR(frame.turned_deg(), c.turn_deg, 1e-9) << c.angle_deg;
    // The middle stays, and the lines of the scan have the film's angle in the picture.
    expect_near(frame.scan_from_picture(
                    r.map, {0.5 * (frame.width_px() - 1), 0.5 * (frame.height_px() - 1)}),
                {0.5 * (kWidth - 1), 0.5 * (kHeight - 1)});
    const double a = (c.angle_deg - c.turn_deg) * std::numbers::pi / 180;
    const Vec2 along = frame.scan_from_picture(r.map, {100 * std::sin(a), 100 * std::cos(a)}) -
                       frame.scan_from_picture(r.map, {0, 0});
    const Vec2 step = r.map.linear() * along;
    EXPECT_NEAR(step.y, 0, 1e-9) << "a step along the lines crosses none";
    EXPECT_NEAR(std::abs(step.x), 100.0 / 8, 1e-9);
  }
}

TEST(PictureFrame, TheScreenIsLaidStraight) {
  for (const double angle_deg : {5.0, 40.0, 85.0, -30.0, 120.0}) {
    const Registration r = found(angle_deg);
    const PictureFrame frame({Geometry::kScreen, 0.5, std::nullopt}, r, kWidth, kHeight);
    const auto screen = [&](double x, double y) {
      return r.map.screen_from_scan(frame.scan_from_picture(r.map, {x, y}));
    };
    const Vec2 o = screen(10, 10), x = screen(18, 10) - o, y = screen(10, 18) - o;
    // Eight pixels of half size are two periods, along one axis each.
    EXPECT_NEAR(std::abs(x.x) + std::abs(x.y), 2, 1e-9) << angle_deg;
    EXPECT_NEAR(std::abs(y.x) + std::abs(y.y), 2, 1e-9) << angle_deg;
    EXPECT_NEAR(x.x * y.x + x.y * y.y, 0, 1e-9) << angle_deg;
    // It lies as the scan lies.
    const Vec2 scan_x =
        frame.scan_from_picture(r.map, {18, 10}) - frame.scan_from_picture(r.map, {10, 10});
    EXPECT_GT(scan_x.x, 0) << angle_deg;
    // All of the scan is in it.
    for (const Vec2 corner :
         {Vec2{0, 0}, {kWidth - 1, 0}, {0, kHeight - 1}, {kWidth - 1, kHeight - 1}}) {
      bool seen = false;
      for (int j = 0; j < frame.height_px() && !seen; ++j) {
        for (int i = 0; i < frame.width_px() && !seen; ++i)
          seen = norm(frame.scan_from_picture(r.map, {double(i), double(j)}) - corner) < 2;
      }
      EXPECT_TRUE(seen) << angle_deg << ": " << corner.x << ", " << corner.y;
    }
  }
}

TEST(PictureFrame, RefusesWhatCannotBe) {
  const Registration dufay = found(0);
  Registration paget = dufay;
  paget.screen = "paget";
  const auto make = [](const FrameChoice& choice, const Registration& r) {
    return PictureFrame(choice, r, kWidth, kHeight);
  };
  EXPECT_THROW((void)make({Geometry::kFilm, 1, std::nullopt}, paget), InputError);
  EXPECT_THROW((void)make({Geometry::kScan, 0, std::nullopt}, dufay), InputError);
  EXPECT_THROW((void)make({Geometry::kScan, std::nan(""), std::nullopt}, dufay), InputError);
  EXPECT_THROW((void)make({Geometry::kScan, 1, PixelBounds{400, 0, 500, 10}}, dufay), InputError);
  EXPECT_THROW((void)parse_geometry("upright"), InputError);
}

}  // namespace
}  // namespace reseau
