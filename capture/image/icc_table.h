// Scans whose colour profile is a table (LUT): each pixel's red, green and blue depend on all three
// samples, which no curve per channel can undo. lcms2 turns them into linear light. Thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "core/line/line_format.h"

namespace reseau {

class IccTable {
 public:
  // Null for a profile that is damaged, not of RGB, or has no table for colorimetric rendering.
  [[nodiscard]] static std::unique_ptr<const IccTable> open(std::span<const std::byte> icc);
  ~IccTable();
  IccTable(const IccTable&) = delete;
  IccTable& operator=(const IccTable&) = delete;

  // Lines of 16-bit samples, [line][channel][pixel], in place: red, green and blue become the
  // square roots (times 65535) of linear ProPhoto RGB, white of the profile = 1; other channels
  // stay. A square root keeps the shadows that 16 linear bits would round away: the tone curve to
  // give is a gamma of 2. Returns how many samples lay outside 0..1 and were clipped.
  std::uint64_t to_linear_light(const LineFormat& format, std::span<std::uint16_t> samples) const;

 private:
  struct State;
  explicit IccTable(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace reseau
