#include "core/reconstruct/blurred_cell.h"

#include <algorithm>
#include <complex>
#include <numbers>

namespace reseau {
namespace {
constexpr int kHarmonics = 16;  // each way; what lies beyond is below a 1/64 period wide edge
constexpr double kLeastTransfer = 1e-7;
using Complex = std::complex<double>;
}  // namespace

BlurredCell::BlurredCell(const ScreenPattern& pattern, const Mat2& screen_from_scan,
                         double sigma_px, const BlurShape& shape,
                         const SharpeningKernel* sharpened) {
  constexpr double kPi = std::numbers::pi;
  const Vec2 f_u{screen_from_scan.a, screen_from_scan.b},
      f_v{screen_from_scan.c, screen_from_scan.d};
  table_.assign(kRow * kRow * kStride, 0.0F);
  std::array<Complex, kSize> turn;
  for (std::size_t i = 0; i < kSize; ++i)
    turn[i] = std::polar(1.0, 2 * kPi * static_cast<double>(i) / static_cast<double>(kSize));
  const auto turned = [&turn](int harmonic, std::size_t i) {
    const int positive = harmonic + static_cast<int>(kSize);
    const auto h = static_cast<std::size_t>(positive);
    return turn[(h * i) % kSize];
  };
  std::array<Complex, kSize> row;
  std::vector<double> sum(kSize * kSize);
  for (int color = 0; color < 3; ++color) {
    std::fill(sum.begin(), sum.end(), 0.0);
    // The mask is real: harmonics k and -k together are twice the real part of one of them.
    for (int k = 0; k <= kHarmonics; ++k) {
      row.fill(0);
      bool any = false;
      for (int h = -kHarmonics; h <= kHarmonics; ++h) {
        const Vec2 f = static_cast<double>(h) * f_u + static_cast<double>(k) * f_v;
        double transfer = shape.transfer(f, sigma_px);
        if (std::abs(transfer) < kLeastTransfer) continue;
        if (sharpened != nullptr) transfer *= sharpened->gain(f);
        any = true;
        const Complex c = (k == 0 ? 1.0 : 2.0) * transfer * pattern.fourier(color, h, k);
        for (std::size_t i = 0; i < kSize; ++i) row[i] += c * turned(h, i);
      }
      if (!any) continue;
      for (std::size_t j = 0; j < kSize; ++j) {
        const Complex t = turned(k, j);
        double* to = &sum[j * kSize];
        for (std::size_t i = 0; i < kSize; ++i)
          to[i] += row[i].real() * t.real() - row[i].imag() * t.imag();
      }
    }
    for (std::size_t j = 0; j < kRow; ++j) {
      for (std::size_t i = 0; i < kRow; ++i) {
        // Deconvolved pixels overshoot.
        const double share = sum[(j % kSize) * kSize + i % kSize];
        table_[(j * kRow + i) * kStride + static_cast<std::size_t>(color)] =
            static_cast<float>(sharpened != nullptr ? share : std::clamp(share, 0.0, 1.0));
      }
    }
  }
  // The series rings a little at hard edges; shares must still sum to one.
  for (std::size_t i = 0; i < table_.size(); i += kStride) {
    const float total = table_[i] + table_[i + 1] + table_[i + 2];
    for (std::size_t k = 0; k < 3; ++k) table_[i + k] /= total;
  }
  std::array<double, 3> total{};
  for (std::size_t j = 0; j < kSize; ++j) {
    for (std::size_t i = 0; i < kSize; ++i) {
      const float* m = &table_[(j * kRow + i) * kStride];
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
