// What is skipped in the dark, against the picture without shortcuts; and that it costs less.
#include <cmath>
#include <cstddef>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/line/memory_line_source.h"
#include "core/reconstruct/reconstruct.h"
#include "tests/support/picture.h"
#include "tests/support/synthetic_scan.h"

namespace reseau {
namespace {

std::array<double, 3> half_black(double x, double y) {
  if (x < 256) return {0.003, 0.003, 0.003};
  const double wave = 0.3 + 0.2 * std::sin(x / 40) * std::cos(y / 50);
  return {wave, 0.7 * wave, 0.5};
}
std::array<double, 3> faint_colour(double x, double y) {
  if (x < 256) return {0.02, 0.0, 0.0};
  return half_black(x, y);
}

struct Pair {
  test::MemorySink quick, exact;
  bool said = false;
  double blank = 0, blank_exact = 0;  // fraction of the pixels that was skipped
};

Pair render(std::array<double, 3> (*scene)(double, double), Quality quality) {
  test::SyntheticScan scan;
  scan.width_px = 512;
  scan.height_px = 400;
  scan.scene = scene;
  scan.noise = 0.002;
  const MemoryLineSource source = scan.render();
  const Registration registration = register_screen(source, {}, {}, {});
  EXPECT_TRUE(registration.found) << registration.reason;
  Pair pair;
  if (!registration.found) return pair;
  ReconstructOptions options;
  options.white_level = scan.exposure;
  options.quality = quality;
  const ReconstructionReport report =
      reconstruct(source, registration, options, pair.quick, {}, {});
  for (const std::string& what : report.skipped)
    pair.said = pair.said || what.find("only noise") != std::string::npos;
  pair.blank = report.blank_fraction;
  options.exact = true;
  pair.blank_exact = reconstruct(source, registration, options, pair.exact, {}, {}).blank_fraction;
  return pair;
}

// Largest difference of the two, and of the mean over squares of 24 pixels, in columns [x0, x1).
std::array<double, 2> differences(const Pair& pair, int x0, int x1) {
  double pixel = 0, square = 0;
  constexpr int kSide = 24;
  const int width = pair.exact.width;
  for (int y = 0; y < pair.exact.height; ++y) {
    for (int x = x0; x < x1; ++x) {
      const std::size_t at = 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                                  static_cast<std::size_t>(x));
      for (std::size_t c = 0; c < 3; ++c)
        pixel = std::max(pixel,
                         std::abs(double{pair.quick.rgb[at + c]} - double{pair.exact.rgb[at + c]}));
    }
  }
  for (int y = 0; y + kSide < pair.exact.height; y += kSide) {
    for (int x = x0; x + kSide < x1; x += kSide) {
      const auto a = pair.quick.mean(x, y, x + kSide, y + kSide),
                 b = pair.exact.mean(x, y, x + kSide, y + kSide);
      for (std::size_t c = 0; c < 3; ++c) square = std::max(square, std::abs(a[c] - b[c]));
    }
  }
  return {pixel, square};
}

TEST(Blank, WhatIsSkippedInTheDarkIsNoise) {
  for (const Quality quality : {Quality::kDraft, Quality::kStandard, Quality::kBest}) {
    const Pair pair = render(half_black, quality);
    EXPECT_TRUE(pair.said);
    // Half of the picture is black; blocks that touch the light are made.
    EXPECT_GT(pair.blank, 0.35);
    EXPECT_LT(pair.blank, 0.5);
    EXPECT_EQ(pair.blank_exact, 0);
    const auto dark = differences(pair, 0, 200), light = differences(pair, 300, 512);
    fmt::print("dark {:.5f} a pixel, {:.5f} a square; light {:.6f}\n", dark[0], dark[1], light[0]);
    EXPECT_GT(dark[0], 0) << "something was skipped";
    EXPECT_LT(dark[0], 0.012);   // six deviations of the noise
    EXPECT_LT(dark[1], 0.0015);  // what is left of it over a square
    // Only what else is not exact: a blur that changes by less than 0.02 px over the frame.
    EXPECT_LT(light[0], 0.002);
  }
}

// Dark, but the réseau shows: the elements differ by ten times the noise.
TEST(Blank, AFaintColourIsKept) {
  const Pair pair = render(faint_colour, Quality::kStandard);
  EXPECT_EQ(pair.blank, 0);
  const auto dark = differences(pair, 0, 200);
  EXPECT_LT(dark[0], 2e-4);
}

}  // namespace
}  // namespace reseau
