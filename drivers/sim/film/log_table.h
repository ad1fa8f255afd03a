#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

namespace reseau::sim {

// A function of a positive number, linear between nodes 1/128 octave apart: cheap where a
// logarithm would be computed for every cell. Arguments are clamped to 2^-24 … 2^5.
class LogTable {
 public:
  LogTable() = default;
  template <typename Function>
  explicit LogTable(const Function& f) {
    const std::uint32_t first = std::bit_cast<std::uint32_t>(kSmallest) >> kShift;
    const std::uint32_t last = std::bit_cast<std::uint32_t>(kLargest) >> kShift;
    for (std::uint32_t i = first; i <= last + 1; ++i) {
      values_.push_back(
          static_cast<float>(f(static_cast<double>(std::bit_cast<float>(i << kShift)))));
    }
  }
  [[nodiscard]] float operator()(float x) const {
    x = std::clamp(x, kSmallest, kLargest);
    const auto bits = std::bit_cast<std::uint32_t>(x);
    const std::uint32_t i = (bits >> kShift) - (std::bit_cast<std::uint32_t>(kSmallest) >> kShift);
    const auto f = static_cast<float>(static_cast<std::int32_t>(bits & ((1U << kShift) - 1))) *
                   (1.0F / static_cast<float>(1U << kShift));
    return values_[i] + f * (values_[i + 1] - values_[i]);
  }

 private:
  static constexpr int kShift = 16;  // keeps 7 bits of the mantissa
  static constexpr float kSmallest = 5.9604645e-8F, kLargest = 32.0F;
  std::vector<float> values_;
};

}  // namespace reseau::sim
