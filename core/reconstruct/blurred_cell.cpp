#include "core/reconstruct/blurred_cell.h"

#include <algorithm>
#include <complex>
#include <numbers>

namespace reseau {
namespace {
constexpr int kHarmonics = 16;  // each way; what lies beyond is below a 1/64 period wide edge
using Complex = std::complex<double>;
}  // namespace

BlurredCell::BlurredCell(const ScreenPattern& pattern, const Mat2& screen_from_scan,
                         double sigma_px) {
  constexpr double kPi = std::numbers::pi;
  const Vec2 f_u{screen_from_scan.a, screen_from_scan.b},
      f_v{screen_from_scan.c, screen_from_scan.d};
  constexpr int kRow = static_cast<int>(kSize) + 2;
  table_.assign(static_cast<std::size_t>(kRow) * kRow * 3, 0.0F);
  const auto turn = [](int harmonic, int i) {
    return std::polar(
        1.0, 2 * kPi * ((harmonic * i) % static_cast<int>(kSize)) / static_cast<double>(kSize));
  };
  std::vector<Complex> along_u(kSize * (2 * kHarmonics + 1));
  for (int color = 0; color < 3; ++color) {
    for (int k = -kHarmonics; k <= kHarmonics; ++k) {
      for (int i = 0; i < static_cast<int>(kSize); ++i) {
        Complex sum = 0;
        for (int h = -kHarmonics; h <= kHarmonics; ++h) {
          const Vec2 f = static_cast<double>(h) * f_u + static_cast<double>(k) * f_v;
          const double otf = std::exp(-2 * kPi * kPi * sigma_px * sigma_px * dot(f, f));
          if (otf < 1e-7) continue;
          sum += pattern.fourier(color, h, k) * otf * turn(h, i);
        }
        along_u[static_cast<std::size_t>(i) * (2 * kHarmonics + 1) +
                static_cast<std::size_t>(k + kHarmonics)] = sum;
      }
    }
    for (int j = 0; j < kRow; ++j) {
      for (int i = 0; i < kRow; ++i) {
        double sum = 0;
        for (int k = -kHarmonics; k <= kHarmonics; ++k) {
          sum += (along_u[(static_cast<std::size_t>(i) % kSize) * (2 * kHarmonics + 1) +
                          static_cast<std::size_t>(k + kHarmonics)] *
                  turn(k, j))
                     .real();
        }
        table_[(static_cast<std::size_t>(j) * kRow + static_cast<std::size_t>(i)) * 3 +
               static_cast<std::size_t>(color)] = static_cast<float>(std::clamp(sum, 0.0, 1.0));
      }
    }
  }
  // The series rings a little at hard edges; shares must still sum to one.
  for (std::size_t i = 0; i < table_.size(); i += 3) {
    const float sum = table_[i] + table_[i + 1] + table_[i + 2];
    for (std::size_t k = 0; k < 3; ++k) table_[i + k] /= sum;
  }
  std::array<double, 3> total{};
  for (std::size_t j = 0; j < kSize; ++j) {
    for (std::size_t i = 0; i < kSize; ++i) {
      const float* m = &table_[(j * (kSize + 2) + i) * 3];
      for (std::size_t k = 0; k < 3; ++k) {
        const double weight = static_cast<double>(m[k]) * static_cast<double>(m[k]);
        total[k] += weight;
        for (std::size_t l = 0; l < 3; ++l) crosstalk_[k][l] += weight * static_cast<double>(m[l]);
      }
    }
  }
  for (std::size_t k = 0; k < 3; ++k) {
    for (double& value : crosstalk_[k]) value /= total[k];
  }
}

}  // namespace reseau
