#include "core/color/pixel_matrix.h"

#include <algorithm>
#include <array>

#include "core/base/check.h"
#include "core/base/parallel.h"

namespace reseau {

void transform_pixels(std::span<float> rgb, const Matrix3& matrix) {
  CHECK(rgb.size() % 3 == 0);
  std::array<float, 9> m{};
  std::transform(matrix.begin(), matrix.end(), m.begin(),
                 [](double v) { return static_cast<float>(v); });
  constexpr std::size_t kPixelsAtOnce = 1U << 16;
  const std::size_t n_pixels = rgb.size() / 3;
  const auto n_pieces = static_cast<int>((n_pixels + kPixelsAtOnce - 1) / kPixelsAtOnce);
  parallel_for(n_pieces, [&](int piece) {
    const std::size_t first = static_cast<std::size_t>(piece) * kPixelsAtOnce;
    float* p = rgb.data() + 3 * first;
    float* const end = rgb.data() + 3 * std::min(n_pixels, first + kPixelsAtOnce);
    for (; p != end; p += 3) {
      const float r = p[0], g = p[1], b = p[2];
      p[0] = m[0] * r + m[1] * g + m[2] * b;
      p[1] = m[3] * r + m[4] * g + m[5] * b;
      p[2] = m[6] * r + m[7] * g + m[8] * b;
    }
  });
}

}  // namespace reseau
