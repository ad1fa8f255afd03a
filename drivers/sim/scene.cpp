#include "drivers/sim/scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace reseau::sim {

void Scene::cells(double y, double x0, double side_px, const RgbRow& out) const {
  thread_local std::vector<float> scratch;
  const std::size_t n_out = out.r.size();
  const double first = std::floor(x0);
  const auto n =
      static_cast<std::size_t>(std::ceil(x0 - first + static_cast<double>(n_out) * side_px)) + 2;
  scratch.resize(3 * n);
  const RgbRow pixels{{scratch.data(), n}, {scratch.data() + n, n}, {scratch.data() + 2 * n, n}};
  row(y, first, pixels);
  const std::array<std::span<float>, 3> from{pixels.r, pixels.g, pixels.b};
  const std::array<std::span<float>, 3> to{out.r, out.g, out.b};
  for (std::size_t i = 0; i < n_out; ++i) {
    const double x = x0 - first + static_cast<double>(i) * side_px;
    const auto left = static_cast<std::size_t>(x);
    const auto w = static_cast<float>(x - static_cast<double>(left));
    for (std::size_t k = 0; k < 3; ++k) {
      to[k][i] = from[k][left] + w * (from[k][left + 1] - from[k][left]);
    }
  }
}

// A tent is the mean of the cells around: of four, by Gauss's rule.
void Scene::tents(double y, double x0, double side_px, const RgbRow& out) const {
  thread_local std::vector<float> scratch;
  const std::size_t n = out.r.size();
  scratch.resize(3 * n);
  const RgbRow even{{scratch.data(), n}, {scratch.data() + n, n}, {scratch.data() + 2 * n, n}};
  const std::array<std::span<float>, 3> from{even.r, even.g, even.b}, to{out.r, out.g, out.b};
  for (const std::span<float> band : to) std::ranges::fill(band, 0.0F);
  const double off = side_px * std::sqrt(1.0 / 12);
  for (const double down : {-off, off}) {
    for (const double across : {-off, off}) {
      cells(y + down, x0 + across, side_px, even);
      for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t i = 0; i < n; ++i) to[k][i] += 0.25F * from[k][i];
      }
    }
  }
}

}  // namespace reseau::sim
