#include "core/line/rgb_lines.h"

#include <algorithm>
#include <vector>

#include "core/base/check.h"

namespace reseau {

RgbLines::RgbLines(const LineSource& source) : source_(source), format_(source.format()) {
  std::erase(format_.channels, Channel::kInfrared);
}

void RgbLines::read(int first, int n, std::span<std::uint16_t> out) const {
  CHECK(n >= 0 && out.size() == format_.samples_per_line() * static_cast<std::size_t>(n));
  const LineFormat& whole = source_.format();
  const auto width = static_cast<std::size_t>(whole.width_px);
  std::vector<std::uint16_t> lines(whole.samples_per_line() * static_cast<std::size_t>(n));
  source_.read(first, n, lines);
  auto to = out.begin();
  for (std::size_t at = 0; at < lines.size();) {
    for (const Channel channel : whole.channels) {
      if (channel != Channel::kInfrared) {
        to = std::copy_n(lines.begin() + static_cast<std::ptrdiff_t>(at), width, to);
      }
      at += width;
    }
  }
}

}  // namespace reseau
