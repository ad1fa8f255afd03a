#include "core/reconstruct/registration_summary.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "core/screen/screen_layout.h"

namespace reseau {
namespace {

// The plane that fits the map best over the whole frame: a stage that wobbles bends the slope at
// any one place by more than the lattice is wrong on the whole.
Mat2 mean_linear(const ScreenMap& map, int width_px, int height_px) {
  constexpr int kSteps = 32;
  Vec2 sum_x, sum_y;
  double norm_x = 0, norm_y = 0;
  for (int j = 0; j <= kSteps; ++j) {
    for (int i = 0; i <= kSteps; ++i) {
      const double x = (static_cast<double>(i) / kSteps - 0.5) * (width_px - 1);
      const double y = (static_cast<double>(j) / kSteps - 0.5) * (height_px - 1);
      const Vec2 s = map.screen_from_scan({x + (width_px - 1) / 2.0, y + (height_px - 1) / 2.0});
      sum_x = sum_x + x * s;
      sum_y = sum_y + y * s;
      norm_x += x * x;
      norm_y += y * y;
    }
  }
  return {sum_x.x / norm_x, sum_y.x / norm_y, sum_x.y / norm_x, sum_y.y / norm_y};
}

}  // namespace

Mat2 describe_lattice(Registration& result, const LineFormat& format, int n_lines) {
  const Mat2 mean = mean_linear(result.map, format.width_px, n_lines);
  result.lattice_cy_per_px = {Vec2{mean.a, mean.b}, Vec2{mean.c, mean.d}};
  if (result.lines_alone) result.lattice_cy_per_px[0] = {};
  result.period_px = {1 / norm(result.lattice_cy_per_px[0]), 1 / norm(result.lattice_cy_per_px[1])};
  // Red lines run along u: the direction in which v stays the same.
  Vec2 along{-mean.d, mean.c};
  if (along.y < 0) along = -1.0 * along;
  result.angle_deg = std::atan2(along.x, along.y) * 180 / std::numbers::pi;
  if (format.x_dpi > 0) {
    for (std::size_t i = result.lines_alone ? 1 : 0; i < 2; ++i)
      result.period_um[i] = result.period_px[i] * 25400 / format.x_dpi;
  }
  return mean;
}

void describe_certainty(Registration& result, const Mat2& mean) {
  const Mat2& sd = result.uncertainty.slope_sd();
  // The length of a frequency along itself, and its direction.
  const auto along = [](Vec2 f, Vec2 s) { return std::hypot(f.x * s.x, f.y * s.y) / norm(f); };
  const auto across = [](Vec2 f, Vec2 s) { return std::hypot(f.y * s.x, f.x * s.y) / norm(f); };
  const Vec2 u{mean.a, mean.b}, v{mean.c, mean.d}, sd_u{sd.a, sd.b}, sd_v{sd.c, sd.d};
  result.period_sd_px = {along(u, sd_u) / dot(u, u), along(v, sd_v) / dot(v, v)};
  if (result.lines_alone) result.period_sd_px[0] = std::numeric_limits<double>::infinity();
  result.angle_sd_deg = across(v, sd_v) / norm(v) * 180 / std::numbers::pi;
}

void describe_names(Registration& result, const LatticeSeed& seed,
                    const std::vector<PatternEvidence>& patterns) {
  const std::vector<ScreenGuess> guesses = name_screen(
      {seed.layout, seed.grey ? -1 : seed.special_color, seed.explained, seed.other_explained,
       result.lines_alone ? result.period_um[1]
                          : std::sqrt(result.period_um[0] * result.period_um[1]),
       patterns});
  const double some = 1 - result.none_probability;
  result.screen = guesses[0].name;
  result.screen_probability = some * guesses[0].probability;
  result.runner_up = guesses[1].name;
  result.runner_up_probability = some * guesses[1].probability;
  if (result.none_probability > result.runner_up_probability) {
    result.runner_up = "none";
    result.runner_up_probability = result.none_probability;
  }
}

void describe_printing(Registration& result, const std::vector<PatternEvidence>& patterns) {
  double total = 0;
  for (const PatternEvidence& p : patterns) total += std::exp(p.log_likelihood);
  for (const PatternEvidence& p : patterns) {
    const double probability = std::exp(p.log_likelihood) / total;
    if (probability <= result.printing_probability) continue;
    result.printing_probability = probability;
    result.printing = screen_names()[static_cast<std::size_t>(p.kind)].name;
  }
}

bool folds(const ScreenMap& map, const Mat2& mean, const LineFormat& format) {
  constexpr int kSteps = 64;
  for (int j = 0; j <= kSteps; ++j) {
    for (int i = 0; i <= kSteps; ++i) {
      const Vec2 p{(format.width_px - 1.0) * i / kSteps, (format.n_lines - 1.0) * j / kSteps};
      const double area = map.jacobian(p).determinant() / mean.determinant();
      if (!(area > 1.0 / 3 && area < 3)) return true;
    }
  }
  return false;
}

}  // namespace reseau
