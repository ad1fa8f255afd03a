#include "drivers/sim/pie/pie_sensor.h"

#include <algorithm>
#include <cmath>

#include "drivers/sim/film.h"
#include "drivers/sim/hash.h"

namespace reseau::sim::pie {
namespace {

// Near enough to a normal deviate for patterns: the sum of four uniform numbers, scaled.
double rough_normal(std::uint64_t bits) {
  double sum = 0;
  for (int i = 0; i < 4; ++i) sum += static_cast<double>(bits >> (16 * i) & 0xffff) / 65535 - 0.5;
  return sum * std::sqrt(3.0);
}

}  // namespace

PieSensor::PieSensor(const PieModel& model, const SensorSpec& spec, std::uint64_t seed)
    : n_pixels_(model.sensor_px),
      scale_(std::min(1.0, static_cast<double>(model.sensor_px) / model.width_px)),
      margin_(std::floor((model.sensor_px - model.width_px * scale_) / 2)) {
  for (int c = 0; c < kChannels; ++c) {
    for (int pixel = 0; pixel < n_pixels_; ++pixel) {
      const double rho = 2.0 * (pixel + 0.5) / n_pixels_ - 1;
      const std::uint64_t key = mix64(mix64(seed, 0x91e0 + static_cast<std::uint64_t>(c)),
                                      static_cast<std::uint64_t>(pixel));
      const double light = std::max(0.05, 1 - spec.shading * rho * rho);
      gain_.push_back(
          static_cast<float>(light * std::max(0.1, 1 + spec.pixel_gain * rough_normal(key))));
      dark_.push_back(static_cast<float>(
          std::max(0.0, spec.dark_level + spec.dark_pattern * rough_normal(mix64(key, 1)))));
    }
  }
}

int PieSensor::pixel_at(double x) const {
  return std::clamp(static_cast<int>(std::floor(margin_ + (x + 0.5) * scale_)), 0, n_pixels_ - 1);
}

}  // namespace reseau::sim::pie
