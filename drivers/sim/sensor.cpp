#include "drivers/sim/sensor.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "core/base/check.h"
#include "drivers/sim/film.h"
#include "drivers/sim/hash.h"
#include "drivers/sim/scan_geometry.h"
#include "drivers/sim/sensor_curves.h"

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

// Whether light becomes a signal by one factor alone.
bool is_even(const SensorSpec& s) {
  const bool lines = s.n_lines > 1 && (s.line_gain != 0 || s.line_response != 0);
  return s.dark_level == 0 && s.dark_pattern == 0 && s.pixel_gain == 0 && s.shading == 0 && !lines;
}

// What the pixels of one sensor line make of the light in one channel.
class PixelLine {
 public:
  PixelLine(const SensorSpec& sensor, const ScanWindow& window, const SensorPass& pass, int line,
            std::size_t channel)
      : response_(sensor.one_response ? 1 : channel, line, sensor.line_response) {
    constexpr std::array<double, 3> kGainSign{0, 1, -1};
    const std::vector<float>& normal = normal_table();
    const double averaged = 1 / std::sqrt(static_cast<double>(window.pitch));
    const double half = pass.field_px / 2.0, axis = (pass.field_px - 1) / 2.0;
    const std::uint64_t key =
        mix64(mix64(mix64(pass.seed, 0x5e4507), channel), static_cast<std::uint64_t>(line));
    for (int i = 0; i < window.width_px; ++i) {
      const double x = window.optical_x(i), rho = (x - axis) / half;
      const int pixel = window.x_px + i * window.pitch;
      const std::uint64_t bits = mix64(key, static_cast<std::uint64_t>(pixel));
      const double gain = 1 + averaged * sensor.pixel_gain * normal[bits & 0xffff];
      const double light = std::max(0.0, 1 - sensor.shading * rho * rho);
      const double side = 1 + sensor.line_gain * kGainSign[static_cast<std::size_t>(line)];
      gain_.push_back(static_cast<float>(gain * light * side));
      const double dark =
          sensor.dark_level + averaged * sensor.dark_pattern * normal[(bits >> 16) & 0xffff];
      dark_.push_back(static_cast<float>(dark));
    }
  }
  [[nodiscard]] float light(std::size_t i, float even) const { return response_(even * gain_[i]); }
  [[nodiscard]] float dark(std::size_t i) const { return dark_[i]; }

 private:
  LineResponse response_;
  std::vector<float> gain_, dark_;
};

}  // namespace

NoiseModel noise_model(const SensorSpec& sensor, int pitch) {
  // Averaging over the pitch lowers the noise.
  const double total = sensor.noise / std::sqrt(static_cast<double>(pitch));
  const double extra =
      sensor.read_noise * sensor.read_noise + sensor.dark_noise * sensor.dark_noise;
  const double step = 1.0 / ((1 << sensor.adc_bits) - 1);
  return {total * total * kReadShare * kReadShare + extra / pitch,
          total * total * (1 - kReadShare * kReadShare), step * step / 12};
}

void digitise(std::span<const float> transmittance, const ScanWindow& window, int first_line,
              const SensorSpec& sensor, const SensorPass& pass, std::span<std::uint16_t> out) {
  CHECK(transmittance.size() == out.size());
  const auto width = static_cast<std::size_t>(window.width_px);
  const std::size_t n_lines = out.size() / (width * kChannels);
  CHECK(n_lines * width * kChannels == out.size());
  const std::vector<float>& normal = normal_table();
  const auto full = static_cast<float>((1 << sensor.adc_bits) - 1);
  const NoiseModel noise = noise_model(sensor, window.pitch);
  const auto read_variance = static_cast<float>(noise.constant);
  const auto shot_variance = static_cast<float>(noise.per_signal);
  const std::uint64_t pass_key =
      mix64(mix64(pass.seed, pass.pass), static_cast<std::uint64_t>(pass.reading));
  const bool even = is_even(sensor);
  std::vector<PixelLine> pixels;  // [sensor line][channel]
  if (!even) {
    for (int line = 0; line < sensor.n_lines; ++line) {
      for (std::size_t c = 0; c < kChannels; ++c) {
        pixels.emplace_back(sensor, window, pass, line, c);
      }
    }
  }
  for (std::size_t l = 0; l < n_lines; ++l) {
    const std::int64_t line = first_line + static_cast<std::int64_t>(l);
    const std::int64_t y = window.y_px + line * window.step();
    const std::uint64_t line_key = mix64(pass_key, static_cast<std::uint64_t>(y));
    const int index =
        even ? 0 : sensor_line(window.optical_y(static_cast<double>(line)), sensor).index;
    const std::size_t at = l * kChannels * width;
    for (std::size_t i = 0; i < width; ++i) {
      const std::int64_t x = window.x_px + static_cast<std::int64_t>(i) * window.pitch;
      const std::uint64_t bits = mix64(line_key, static_cast<std::uint64_t>(x));
      for (std::size_t c = 0; c < kChannels; ++c) {
        float signal = transmittance[at + c * width + i] * static_cast<float>(pass.level[c]);
        float dark = 0;
        if (!even) {
          const PixelLine& p = pixels[static_cast<std::size_t>(index) * kChannels + c];
          signal = p.light(i, signal);
          dark = p.dark(i);
        }
        const float sigma = std::sqrt(read_variance + shot_variance * std::max(signal, 0.0F));
        const float noisy = signal + sigma * normal[(bits >> (16 * c)) & 0xffff] + dark;
        const float code = noisy * full + 0.5F;
        out[at + c * width + i] = static_cast<std::uint16_t>(std::clamp(code, 0.0F, full));
      }
    }
  }
}

}  // namespace reseau::sim
