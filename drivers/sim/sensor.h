// Exposure, noise and A/D conversion of rendered lines.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "drivers/sim/optics_spec.h"
#include "drivers/sim/scan_renderer.h"

namespace reseau::sim {

struct SensorPass {
  // Fraction of full scale that a transmittance of 1 reaches, per channel R G B IR.
  std::array<double, 4> level{};
  std::uint64_t seed = 1;
  std::uint64_t pass = 0;  // another pass over the same place has other noise
  int reading = 0;         // so has another reading of the same line
  int field_px = 1;        // of the lens, from pixel 0 on: shading falls towards its ends
};

// Variance of one reading of a sample whose light is a given fraction of full scale: constant +
// per_signal * light. All as fractions of full scale (squared).
struct NoiseModel {
  double constant = 0;      // read noise and the dark current's
  double per_signal = 0;    // photons
  double quantisation = 0;  // of the A/D converter, a step squared / 12; not part of constant
  [[nodiscard]] double variance(double light) const {
    return constant + per_signal * light + quantisation;
  }
};
// pitch: as in ScanWindow; averaging over it lowers all but the last part.
[[nodiscard]] NoiseModel noise_model(const SensorSpec& sensor, int pitch);

// Turns transmittances [line][channel][pixel] of lines first_line … into A/D values, 0 to
// 2^adc_bits - 1, clipped. Thread-safe; a value depends on its position, not on the call.
void digitise(std::span<const float> transmittance, const ScanWindow& window, int first_line,
              const SensorSpec& sensor, const SensorPass& pass, std::span<std::uint16_t> out);

}  // namespace reseau::sim
