#include "core/screen/element_model.h"

#include <cstddef>
#include <numbers>

namespace reseau {

ElementModel::ElementModel(const Mat2& linear, const ScreenPattern& pattern) {
  const Mat2 t = linear.transposed();
  for (int k = 0; k < 3; ++k) sharp_(0, k) = pattern.area(k);
  for (int i = 1; i < kTileAmplitudes; ++i) {
    const HarmonicIndex h = kTileHarmonics[static_cast<std::size_t>(i - 1)];
    frequency_[static_cast<std::size_t>(i)] =
        t * Vec2{static_cast<double>(h.u), static_cast<double>(h.v)};
    for (int k = 0; k < 3; ++k)
      sharp_(i, k) = std::numbers::sqrt2 * pattern.fourier(k, h.u, h.v).real();
  }
}

ElementModel::ElementModel(const Mat2& linear, ScreenLayout layout) {
  const SiteSeries& series = site_series(layout);
  const Mat2 t = linear.transposed();
  for (int i = 0; i < kTileAmplitudes; ++i) {
    if (i > 0) {
      const HarmonicIndex h = kTileHarmonics[static_cast<std::size_t>(i - 1)];
      frequency_[static_cast<std::size_t>(i)] =
          t * Vec2{static_cast<double>(h.u), static_cast<double>(h.v)};
    }
    for (int k = 0; k < 3; ++k) {
      sharp_(i, k) = (i > 0 ? std::numbers::sqrt2 : 1.0) *
                     series[static_cast<std::size_t>(k)][static_cast<std::size_t>(i)];
    }
  }
}

ElementModel::Columns ElementModel::columns(double sigma_px, const BlurShape& shape) const {
  Amplitudes otf;
  for (int i = 0; i < kTileAmplitudes; ++i)
    otf(i) = shape.transfer(frequency_[static_cast<std::size_t>(i)], sigma_px);
  return otf.asDiagonal() * sharp_;
}

ElementModel::Amplitudes weighted_amplitudes(const std::array<double, kTileAmplitudes>& amplitude) {
  ElementModel::Amplitudes y;
  y(0) = amplitude[0];
  for (int i = 1; i < kTileAmplitudes; ++i) {
    y(i) = std::numbers::sqrt2 * amplitude[static_cast<std::size_t>(i)];
  }
  return y;
}

}  // namespace reseau
