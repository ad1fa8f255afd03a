#pragma once

#include <cmath>
#include <cstdint>

#include "drivers/sim/film_spec.h"
#include "drivers/sim/hash.h"

namespace reseau::sim {

// Errors of one line at one place along it, or of one polygon or disc. Displacements in units of
// one standard deviation.
struct PrintError {
  float across = 0, along = 0, width = 0;
  bool missing = false;
};

// Remembers the last line and place, for rows of cells go along lines. One per row and shape.
class PrintingNoise {
 public:
  PrintingNoise(const PrintSpec& spec, std::uint64_t key)
      : key_(key),
        missing_(spec.missing),
        rough_(spec.position_noise_um > 0 || spec.width_noise_um > 0) {}

  // No displacement is larger [standard deviations].
  static constexpr float kLargest = 4.9F;

  [[nodiscard]] bool can_miss() const { return missing_ > 0; }
  [[nodiscard]] bool is_missing(std::int64_t index) {
    if (index != index_) choose(index);
    return is_missing_;
  }
  // Line `index` at `place`, in units of the length over which errors change.
  [[nodiscard]] PrintError line(std::int64_t index, double place) {
    if (index != index_) choose(index);
    PrintError error;
    if (!rough_) return error;
    const double floor = std::floor(place);
    const auto knot = static_cast<std::int64_t>(floor);
    if (!has_knots_ || knot != knot_) {
      knot_ = knot;
      has_knots_ = true;
      for (int k = 0; k < 2; ++k) {
        const std::uint64_t bits = mix64(line_key_ + 2, static_cast<std::uint64_t>(knot + k));
        across_[k] = normal(bits);
        width_[k] = normal(mix64(bits));
      }
    }
    const auto f = static_cast<float>(place - floor);
    // Weights whose squares sum to 1 (within 6 %), so that the spread is the same between knots.
    const float b = f * (1.5F - 0.5F * f * f), g = 1 - f, a = g * (1.5F - 0.5F * g * g);
    error.across = a * across_[0] + b * across_[1];
    error.width = a * width_[0] + b * width_[1];
    return error;
  }

  [[nodiscard]] PrintError shape(std::int64_t index_u, std::int64_t index_v) {
    if (index_u != index_ || index_v != knot_ || !has_knots_) {
      index_ = index_u;
      knot_ = index_v;
      has_knots_ = true;
      const std::uint64_t bits = mix64(mix64(key_, static_cast<std::uint64_t>(index_u)),
                                       static_cast<std::uint64_t>(index_v));
      last_.missing = missing_ > 0 && uniform(mix64(bits, 1)) < missing_;
      if (rough_) {
        last_.across = normal(mix64(bits, 2));
        last_.along = normal(mix64(bits, 3));
        last_.width = normal(mix64(bits, 4));
      }
    }
    return last_;
  }

 private:
  void choose(std::int64_t index) {
    index_ = index;
    line_key_ = mix64(key_, static_cast<std::uint64_t>(index));
    is_missing_ = missing_ > 0 && uniform(mix64(line_key_, 1)) < missing_;
    has_knots_ = false;
  }
  static double uniform(std::uint64_t bits) {
    return (static_cast<double>(signed_unit(bits)) + 1) / 2;
  }
  // Sum of four uniform numbers: nearly normal, never beyond 3.5 standard deviations.
  static float normal(std::uint64_t bits) {
    float sum = -2.0F;
    for (int k = 0; k < 4; ++k) {
      sum += (static_cast<float>(bits >> (16 * k) & 0xffff) + 0.5F) / 65536.0F;
    }
    return sum * 1.7320508F;
  }
  std::uint64_t key_, line_key_ = 0;
  double missing_;
  bool rough_, is_missing_ = false, has_knots_ = false;
  std::int64_t index_ = INT64_MIN, knot_ = 0;
  float across_[2]{}, width_[2]{};
  PrintError last_;
};

}  // namespace reseau::sim
