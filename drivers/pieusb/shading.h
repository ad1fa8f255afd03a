// Shading: units of this family deliver what their sensor saw, and the host evens out light and
// pixels with lines that the unit took without film. Pure.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "drivers/bytes.h"

namespace reseau::pieusb {

// What a calibration measured, column by column of the sensor [0..65535]; empty = not measured.
struct ShadingReference {
  int width_px = 0;
  std::array<std::vector<float>, 4> dark, light;  // red green blue infrared
  std::array<int, 4> n_dark{}, n_light{};         // lines that were averaged
};

// lines: 16-bit index lines of width_px samples, one after the other. Dark and light lines are told
// apart by their level, never by their number. Throws DeviceError when a visible colour has no
// light lines, or too little light, which a lamp that is off gives.
[[nodiscard]] ShadingReference reference_of(ByteView lines, int width_px);

// in → (in - dark) * (mean(light) - mean(dark)) / (light - dark), per channel and output column.
// Without dark lines dark is 0. Channels that were not measured, usually infrared, stay as they
// are.
class Shading {
 public:
  // used: pixels of the sensor that make the columns of the output, ascending; column j of width_px
  // belongs to the j-th, or to the nearest where their numbers differ.
  Shading(const ShadingReference& reference, const std::vector<int>& used, int width_px);
  // Leaves everything as it is.
  Shading() = default;

  // One row, [channel][pixel], in place. Results are rounded and clamped;
  // full scale stays full scale.
  void apply(std::span<std::uint16_t> row, int n_channels) const;
  [[nodiscard]] bool corrects(int channel) const {
    return !gain_[static_cast<std::size_t>(channel)].empty();
  }
  // Columns, over all channels, that see too little light to be evened out; they take the gain of
  // their neighbours.
  [[nodiscard]] int n_weak() const { return n_weak_; }

 private:
  std::array<std::vector<float>, 4> dark_, gain_;
  int n_weak_ = 0;
};

}  // namespace reseau::pieusb
