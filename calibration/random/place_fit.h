// Where a picture lies in the random target, and how wide a Gaussian it is blurred by: the start of
// measure_random, and part of it.
#pragma once

#include <array>
#include <optional>

#include "calibration/random/random_cells.h"
#include "core/base/span2d.h"
#include "core/geometry/vec2.h"

namespace reseau::random_target {

// The square of pixels that is used; places in it are told from its middle, over half its side.
struct UsedPart {
  Span2D<const float> samples;  // not finite: left out
  double half_px() const { return 0.5 * samples.width(); }
  Vec2 middle() const { return {0.5 * (samples.width() - 1), 0.5 * (samples.height() - 1)}; }
};

// Target = sum of coefficients times 1, x, y, x^2, x y, y^2, with x and y in half sides of the
// part.
inline constexpr int kTerms = 6;
using Terms = std::array<double, kTerms>;
struct PlaceInTarget {
  Terms u{}, v{};
  [[nodiscard]] static Terms terms(double x, double y) { return {1, x, y, x * x, x * y, y * y}; }
  [[nodiscard]] Vec2 at(const Terms& terms) const;
  // d(u, v) / d(x, y) in the middle, per half side.
  [[nodiscard]] Mat2 slope() const { return {u[1], u[2], v[1], v[2]}; }
};

struct BlurredPlace {
  PlaceInTarget place;
  double sigma2_u = 0.5, sigma2_v = 0.5;  // of the Gaussian along the target's axes [px^2]
  double dark = 0, contrast = 1;          // levels
  double light_x = 0, light_y = 0;        // how the light grows, relative, per half side
  double explained = 0;                   // of the variance
};

// The whole target is searched, turned by up to 7 degrees from any of the eight ways to lay it in.
// `near`: only about this place instead. Nothing where the picture does not look like the target.
[[nodiscard]] std::optional<BlurredPlace> find_place(const UsedPart& part, const RandomCells& cells,
                                                     const BlurredPlace* near);

}  // namespace reseau::random_target
