// The sensor of a simulated PIE unit: which of its pixels make which column, and what each of them
// makes of the light. Immutable, thread-safe.
#pragma once

#include <array>
#include <vector>

#include "drivers/sim/pie/pie_model.h"

namespace reseau::sim::pie {

class PieSensor {
 public:
  PieSensor(const PieModel& model, const SensorSpec& spec, std::uint64_t seed);

  // Pixel of the sensor behind a position along it [px of the highest resolution, area from 0].
  [[nodiscard]] int pixel_at(double x) const;
  [[nodiscard]] int n_pixels() const { return n_pixels_; }
  // Light that a pixel makes of even light of 1, without its dark level; and that level, as
  // fractions of full scale.
  [[nodiscard]] float gain(int channel, int pixel) const { return gain_[at(channel, pixel)]; }
  [[nodiscard]] float dark(int channel, int pixel) const { return dark_[at(channel, pixel)]; }

 private:
  [[nodiscard]] std::size_t at(int channel, int pixel) const {
    return static_cast<std::size_t>(channel) * static_cast<std::size_t>(n_pixels_) +
           static_cast<std::size_t>(pixel);
  }
  int n_pixels_;
  double scale_, margin_;
  std::vector<float> gain_, dark_;
};

}  // namespace reseau::sim::pie
