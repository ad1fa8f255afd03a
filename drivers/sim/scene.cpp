#include "drivers/sim/scene.h"

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

}  // namespace reseau::sim
