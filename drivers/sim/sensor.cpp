#include "drivers/sim/sensor.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "core/base/check.h"
#include "drivers/sim/film.h"
#include "drivers/sim/hash.h"

namespace reseau::sim {
namespace {

constexpr double kReadShare = 0.2;  // of the noise at full scale

// Quantile of the standard normal distribution by Newton's method on erfc.
double normal_quantile(double p) {
  double x = 0;
  for (int i = 0; i < 60; ++i) {
    const double cdf = 0.5 * std::erfc(-x / std::sqrt(2.0));
    const double pdf = std::exp(-0.5 * x * x) / std::sqrt(2 * 3.14159265358979323846);
    const double step = std::clamp((cdf - p) / pdf, -0.5, 0.5);
    x -= step;
    if (std::abs(step) < 1e-12) break;
  }
  return x;
}

// Normal deviates for every 16-bit number.
const std::vector<float>& normal_table() {
  static const std::vector<float> table = [] {
    std::vector<float> t(65536);
    for (std::size_t i = 0; i < 32768; ++i) {
      t[i] = static_cast<float>(normal_quantile((static_cast<double>(i) + 0.5) / 65536));
      t[65535 - i] = -t[i];
    }
    return t;
  }();
  return table;
}

}  // namespace

void digitise(std::span<const float> transmittance, const ScanWindow& window, int first_line,
              const SensorSpec& sensor, const SensorPass& pass, std::span<std::uint16_t> out) {
  CHECK(transmittance.size() == out.size());
  const auto width = static_cast<std::size_t>(window.width_px);
  const std::size_t n_lines = out.size() / (width * kChannels);
  CHECK(n_lines * width * kChannels == out.size());
  const std::vector<float>& normal = normal_table();
  const auto full = static_cast<float>((1 << sensor.adc_bits) - 1);
  // Averaging over the pitch lowers the noise.
  const double total = sensor.noise / std::sqrt(static_cast<double>(window.pitch));
  const auto read_variance = static_cast<float>(total * total * kReadShare * kReadShare);
  const auto shot_variance = static_cast<float>(total * total * (1 - kReadShare * kReadShare));
  const std::uint64_t pass_key =
      mix64(mix64(pass.seed, pass.pass), static_cast<std::uint64_t>(pass.reading));
  for (std::size_t l = 0; l < n_lines; ++l) {
    const std::int64_t y =
        window.y_px + (first_line + static_cast<std::int64_t>(l)) * window.step();
    const std::uint64_t line_key = mix64(pass_key, static_cast<std::uint64_t>(y));
    const std::size_t at = l * kChannels * width;
    for (std::size_t i = 0; i < width; ++i) {
      const std::int64_t x = window.x_px + static_cast<std::int64_t>(i) * window.pitch;
      const std::uint64_t bits = mix64(line_key, static_cast<std::uint64_t>(x));
      for (std::size_t c = 0; c < kChannels; ++c) {
        const float signal = transmittance[at + c * width + i] * static_cast<float>(pass.level[c]);
        const float sigma = std::sqrt(read_variance + shot_variance * std::max(signal, 0.0F));
        const float noisy = signal + sigma * normal[(bits >> (16 * c)) & 0xffff];
        const float code = noisy * full + 0.5F;
        out[at + c * width + i] = static_cast<std::uint16_t>(std::clamp(code, 0.0F, full));
      }
    }
  }
}

}  // namespace reseau::sim
