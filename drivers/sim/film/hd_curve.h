// Characteristic curve of the reversed silver image.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "drivers/sim/film/log_table.h"

namespace reseau::sim {

struct HdSpec {
  double gamma = 0;      // slope of density against log10 exposure; 0 = transmittance is exposure
  double d_min = 0.05;   // density of full exposure
  double d_max = 2.6;    // density without exposure
  double toe = 0.10;     // density over which either end bends
  double log_speed = 0;  // log10 of the exposure at which the straight line reaches d_min
};

// Density of a positive falls with exposure E:
//   x = gamma (log10 speed - log10 E),  D = d_min + s(x) - s(x - (d_max - d_min)),
//   s(x) = toe ln(1 + exp(x / toe)): a straight line of slope -gamma between two rounded ends.
// With gamma 1, d_min 0, toe -> 0 and d_max -> infinity the transmittance is the exposure.
// Immutable, thread-safe.
class HdCurve {
 public:
  explicit HdCurve(const HdSpec& spec);
  [[nodiscard]] bool is_identity() const { return spec_.gamma == 0; }
  // By the formula; exposure >= 0.
  [[nodiscard]] double transmittance(double exposure) const;
  // From a table, within 2e-5 of the formula. Nothing happens when it is the identity.
  void apply(std::span<float> exposure) const;

 private:
  HdSpec spec_;
  LogTable table_;
};

}  // namespace reseau::sim
