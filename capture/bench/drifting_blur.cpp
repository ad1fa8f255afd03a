#include "capture/bench/drifting_blur.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <random>
#include <vector>

#include "core/base/parallel.h"

namespace reseau {
namespace {

// Weights whose transfer is that of a Gaussian, from -radius to radius: samples of a narrow
// Gaussian itself have too little variance.
std::vector<double> gaussian(double sigma_px) {
  constexpr int kFrequencies = 64;  // of half a cycle per pixel
  constexpr double kPi = std::numbers::pi;
  const int radius = 6 + static_cast<int>(std::ceil(4 * sigma_px));
  std::vector<double> weights;
  for (int i = -radius; i <= radius; ++i) {
    double sum = 0;
    for (int k = 0; k < kFrequencies; ++k) {
      const double f = (k + 0.5) / (2.0 * kFrequencies);
      sum += std::exp(-2 * kPi * kPi * sigma_px * sigma_px * f * f) * std::cos(2 * kPi * f * i);
    }
    weights.push_back(sum / kFrequencies);
  }
  return weights;
}

}  // namespace

void blur_across(const LineFormat& format, double first_px, double last_px, double noise,
                 std::span<std::uint16_t> samples) {
  const int width = format.width_px, height = format.n_lines;
  const auto planes = format.channels.size();
  std::vector<std::vector<double>> kernels;
  for (int x = 0; x < width; ++x) {
    const double sigma = first_px + (last_px - first_px) * x / std::max(1, width - 1);
    kernels.push_back(gaussian(std::sqrt(std::max(sigma * sigma - first_px * first_px, 0.0))));
  }
  const std::vector<std::uint16_t> sharp(samples.begin(), samples.end());
  const auto at = [&](int x, int y, std::size_t plane) {
    const auto column = static_cast<std::size_t>(std::clamp(x, 0, width - 1)),
               row = static_cast<std::size_t>(std::clamp(y, 0, height - 1));
    return sharp[(row * planes + plane) * static_cast<std::size_t>(width) + column];
  };
  parallel_for(height, [&](int y) {
    std::mt19937_64 random(static_cast<std::uint64_t>(y));
    std::normal_distribution<double> normal;
    for (std::size_t plane = 0; plane < planes; ++plane) {
      for (int x = 0; x < width; ++x) {
        const std::vector<double>& k = kernels[static_cast<std::size_t>(x)];
        const int radius = static_cast<int>(k.size() / 2);
        const double* const middle = k.data() + radius;
        double sum = 0;
        for (int j = -radius; j <= radius; ++j) {
          double row = 0;
          for (int i = -radius; i <= radius; ++i) row += middle[i] * at(x + i, y + j, plane);
          sum += middle[j] * row;
        }
        constexpr double kFullScale = 65535;
        sum += noise * kFullScale * normal(random);
        samples[(static_cast<std::size_t>(y) * planes + plane) * static_cast<std::size_t>(width) +
                static_cast<std::size_t>(x)] =
            static_cast<std::uint16_t>(std::lround(std::clamp(sum, 0.0, kFullScale)));
      }
    }
  });
}

}  // namespace reseau
