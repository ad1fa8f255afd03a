#include "core/line/memory_line_source.h"

#include <algorithm>
#include <utility>

#include "core/base/check.h"

namespace reseau {

MemoryLineSource::MemoryLineSource(LineFormat format, std::vector<std::uint16_t> samples)
    : format_(std::move(format)), samples_(std::move(samples)) {
  CHECK(samples_.size() == format_.samples_per_line() * static_cast<std::size_t>(format_.n_lines));
}

int MemoryLineSource::wait_committed(int /*n_lines*/, const std::stop_token& /*stop*/) const {
  return format_.n_lines;
}

void MemoryLineSource::read(int first, int n, std::span<std::uint16_t> out) const {
  CHECK(first >= 0 && n >= 0 && first + n <= format_.n_lines);
  const std::size_t per_line = format_.samples_per_line();
  CHECK(out.size() == per_line * static_cast<std::size_t>(n));
  const auto begin =
      samples_.begin() + static_cast<std::ptrdiff_t>(per_line * static_cast<std::size_t>(first));
  std::copy_n(begin, out.size(), out.begin());
}

}  // namespace reseau
