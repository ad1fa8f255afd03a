#include "calibration/edge/pixel_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "calibration/edge/dense.h"
#include "core/base/check.h"

namespace reseau {

void for_each_edge_pixel(Span2D<const float> samples, std::span<const unsigned char> used,
                         const PixelModel& model,
                         const std::function<void(std::span<const EdgePixel>)>& give) {
  const LineFrame frame(model.line);
  const double c = frame.cosine(), s = frame.sine();
  const double margin =
      model.reach_px + std::abs(model.line.bend_px) * 1.5 + std::abs(model.line.twist_px) + 2;
  std::vector<EdgePixel> row;
  for (int y = 0; y < samples.height(); ++y) {
    int first = 0, last = samples.width() - 1;
    // |c (x - mx) + s (y - my) - offset| <= margin
    const double at = s * (y - model.line.middle.y) - model.line.offset_px;
    if (std::abs(c) > 1e-9) {
      double a = model.line.middle.x + (-margin - at) / c;
      double b = model.line.middle.x + (margin - at) / c;
      if (a > b) std::swap(a, b);
      if (b < first || a > last) continue;
      first = std::max(first, static_cast<int>(std::max(a, 0.0)));
      last = std::min(last, static_cast<int>(std::min(b, double(last))) + 1);
      last = std::min(last, samples.width() - 1);
    } else if (std::abs(at) > margin) {
      continue;
    }
    row.clear();
    const auto line = samples.row(y);
    const std::size_t start =
        static_cast<std::size_t>(y) * static_cast<std::size_t>(samples.width());
    for (int x = first; x <= last; ++x) {
      const auto i = static_cast<std::size_t>(x);
      if (!used.empty() && used[start + i] == 0) continue;
      const double value = double{line[i]};
      if (!std::isfinite(value)) continue;
      const LineFrame::Place place = frame.at(x, y);
      if (std::abs(place.distance) > model.reach_px) continue;
      row.push_back({place.distance, place.along, value, x, y});
    }
    if (!row.empty()) give(row);
  }
}

PixelStep pixel_step(Span2D<const float> samples, std::span<const unsigned char> used,
                     const PixelModel& model, const ProfileFunction& profile, int n_shape,
                     bool with_width, bool with_along) {
  // Order: offset, angle, bend, twist, dark, bright, along x 2, width.
  const std::size_t n_line = 2 + static_cast<std::size_t>(n_shape);
  const std::size_t n_levels = with_along ? 4 : 2;
  const std::size_t p = n_line + n_levels + (with_width ? 1 : 0);
  // On the stack, as sums over all pixels go into them.
  constexpr std::size_t kMost = 9;
  CHECK(p <= kMost);
  std::array<std::array<double, kMost>, kMost> sums{};
  std::array<double, kMost> x{}, pulls{};
  double squares = 0, n = 0;
  const LineFrame frame(model.line);
  const EdgeLevels& l = model.levels;
  std::vector<ProfilePoint> points;
  for_each_edge_pixel(samples, used, model, [&](std::span<const EdgePixel> row) {
    points.resize(row.size());
    profile(row, points);
    for (std::size_t i = 0; i < row.size(); ++i) {
      const EdgePixel& pixel = row[i];
      const ProfilePoint& e = points[i];
      const double v = pixel.along / model.line.half_length_px;
      const double a = pixel.distance / model.reach_px;
      const double dark = l.dark + l.dark_along * v + l.dark_across * a;
      const double bright = l.bright + l.bright_along * v + l.bright_across * a;
      const double rest = pixel.value - (dark * (1 - e.value) + bright * e.value);
      // Where the profile is flat the line has no say.
      constexpr double kFlat = 1e-13;
      const std::size_t from = std::abs(e.slope) > kFlat ? 0 : n_line;
      if (from == 0) {
        const double pull = (bright - dark) * e.slope;
        const auto by_line = frame.derivatives(pixel.along);
        for (std::size_t k = 0; k < n_line; ++k) x[k] = pull * by_line[k];
      }
      x[n_line] = 1 - e.value;
      x[n_line + 1] = e.value;
      if (with_along) {
        x[n_line + 2] = (1 - e.value) * v;
        x[n_line + 3] = e.value * v;
      }
      if (with_width) x[p - 1] = (bright - dark) * e.by_width;
      for (std::size_t j = from; j < p; ++j) {
        const double xj = x[j];
        pulls[j] += xj * rest;
        std::array<double, kMost>& to = sums[j];
        for (std::size_t k = from; k <= j; ++k) to[k] += xj * x[k];
      }
      squares += rest * rest;
      n += 1;
    }
  });
  PixelStep out;
  out.model = model;
  out.n = n;
  out.rms = n > 0 ? std::sqrt(squares / n) : 0;
  if (n < double(2 * p)) return out;
  Symmetric normal(p);
  std::vector<double> g(pulls.begin(), pulls.begin() + static_cast<std::ptrdiff_t>(p));
  for (std::size_t j = 0; j < p; ++j) {
    for (std::size_t k = 0; k <= j; ++k) normal(j, k) = sums[j][k];
  }
  const double contrast = std::abs(l.bright - l.dark);
  for (std::size_t j = 0; j < p; ++j) normal(j, j) += 1e-12 * normal(j, j) + 1e-18 * contrast;
  const Cholesky factor(normal);
  if (!factor.ok()) return out;
  const double variance = out.rms * out.rms * n / std::max(1.0, n - double(p));
  const auto sd = [&](std::size_t j) {
    std::vector<double> unit(p);
    unit[j] = 1;
    factor.solve(unit);
    return std::sqrt(std::max(0.0, unit[j] * variance));
  };
  if (n_shape > 0) out.bend_sd = sd(2);
  if (n_shape > 1) out.twist_sd = sd(3);
  factor.solve(g);
  for (const double step : g) {
    if (!std::isfinite(step)) return out;
  }
  // A step may not leave the neighbourhood in which the profile is a guide.
  const double half = model.line.half_length_px;
  double farthest = std::abs(g[0]) + std::abs(g[1]) * half;
  for (std::size_t k = 2; k < n_line; ++k) farthest += std::abs(g[k]);
  const double allowed = 0.25 * std::max(8.0, model.reach_px);
  const double shrink = farthest > allowed ? allowed / farthest : 1;
  out.moved_px = farthest * shrink;
  EdgeLine& line = out.model.line;
  line.offset_px += g[0] * shrink;
  line.normal_rad += g[1] * shrink;
  if (n_shape > 0) line.bend_px += g[2] * shrink;
  if (n_shape > 1) line.twist_px += g[3] * shrink;
  out.model.levels.dark += g[n_line];
  out.model.levels.bright += g[n_line + 1];
  if (with_along) {
    out.model.levels.dark_along += g[n_line + 2];
    out.model.levels.bright_along += g[n_line + 3];
  }
  if (with_width) out.width_step = g[p - 1];
  out.ok = true;
  return out;
}

}  // namespace reseau
