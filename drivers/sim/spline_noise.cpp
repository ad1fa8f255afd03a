#include "drivers/sim/spline_noise.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "drivers/sim/hash.h"
#include "drivers/sim/spline_weights.h"

namespace reseau::sim {
void SplineNoise::add_row(double y, double x0, float gain, std::span<float> out) const {
  const double ty = y / cell_px_;
  const auto iy = static_cast<std::int64_t>(std::floor(ty));
  const std::array<double, 4> wy = spline_weights(ty - static_cast<double>(iy));
  std::array<std::uint64_t, 4> row_key;
  for (std::size_t j = 0; j < 4; ++j) {
    row_key[j] = mix64(seed_, static_cast<std::uint64_t>(iy + static_cast<std::int64_t>(j)));
  }
  // Coefficient of the column, the vertical sum already taken.
  const auto column = [&](std::int64_t ix) {
    double sum = 0;
    for (std::size_t j = 0; j < 4; ++j) {
      sum += wy[j] * signed_unit(mix64(row_key[j], static_cast<std::uint64_t>(ix)));
    }
    return sum;
  };

  const double step = 1.0 / cell_px_;
  const double tx0 = x0 * step;
  auto ix = static_cast<std::int64_t>(std::floor(tx0));
  std::array<double, 4> c{column(ix), column(ix + 1), column(ix + 2), column(ix + 3)};
  std::size_t i = 0;
  while (i < out.size()) {
    // Samples until the next knot share one cubic.
    const double next_knot = (static_cast<double>(ix + 1) - tx0) * cell_px_;
    const auto end =
        std::min(out.size(), static_cast<std::size_t>(std::max(0.0, std::ceil(next_knot))));
    const auto a0 = static_cast<float>((c[0] + 4 * c[1] + c[2]) / 6);
    const auto a1 = static_cast<float>((c[2] - c[0]) / 2);
    const auto a2 = static_cast<float>((c[0] - 2 * c[1] + c[2]) / 2);
    const auto a3 = static_cast<float>((c[3] - c[0] + 3 * (c[1] - c[2])) / 6);
    const auto knot = static_cast<double>(ix);
    for (; i < end; ++i) {
      // From the place itself, so that rows which begin elsewhere give the same value there.
      const auto f = static_cast<float>((x0 + static_cast<double>(i)) * step - knot);
      out[i] += gain * (a0 + f * (a1 + f * (a2 + f * a3)));
    }
    ++ix;
    c = {c[1], c[2], c[3], column(ix + 3)};
  }
}

}  // namespace reseau::sim
