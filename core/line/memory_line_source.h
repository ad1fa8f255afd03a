#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/line/line_source.h"

namespace reseau {

// A whole scan in memory. Immutable, therefore thread-safe.
class MemoryLineSource final : public LineSource {
 public:
  // samples: [line][channel][pixel], exactly format.n_lines lines.
  MemoryLineSource(LineFormat format, std::vector<std::uint16_t> samples);

  [[nodiscard]] const LineFormat& format() const override { return format_; }
  [[nodiscard]] int committed() const override { return format_.n_lines; }
  int wait_committed(int n_lines, const std::stop_token& stop) const override;
  void read(int first, int n, std::span<std::uint16_t> out) const override;

 private:
  LineFormat format_;
  std::vector<std::uint16_t> samples_;
};

}  // namespace reseau
