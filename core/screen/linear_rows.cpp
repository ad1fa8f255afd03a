#include "core/screen/linear_rows.h"

#include <algorithm>

#include "core/base/check.h"

namespace reseau {
namespace {
// A sample at the top of the scale says only "at least this much".
constexpr std::uint16_t kClipped = 65500;
}  // namespace

LinearReader::LinearReader(const LineSource& source, const ToneCurves& tone)
    : source_(source), tone_(tone) {
  const LineFormat& format = source.format();
  rgb_plane_ = {format.plane_of(Channel::kRed), format.plane_of(Channel::kGreen),
                format.plane_of(Channel::kBlue)};
  for (int plane : rgb_plane_) CHECK(plane >= 0);
  infrared_plane_ = format.plane_of(Channel::kInfrared);
}

void LinearReader::read(int first, int n, LinearRows& out) {
  const LineFormat& format = source_.format();
  const auto width = static_cast<std::size_t>(format.width_px);
  buffer_.resize(format.samples_per_line() * static_cast<std::size_t>(n));
  source_.read(first, n, buffer_);
  out.first = first;
  out.n = n;
  out.width_px = format.width_px;
  for (auto& plane : out.plane) plane.resize(width * static_cast<std::size_t>(n));
  for (std::size_t y = 0; y < static_cast<std::size_t>(n); ++y) {
    if (every_ == 1) {
      convert(y, 0, width, out);
      continue;
    }
    for (std::size_t x0 = 0; x0 < width; x0 += kGroupPx * every_) {
      convert(y, x0, std::min(width, x0 + kGroupPx), out);
    }
  }
}

void LinearReader::convert(std::size_t y, std::size_t x0, std::size_t x1, LinearRows& out) const {
  const LineFormat& format = source_.format();
  const auto width = static_cast<std::size_t>(format.width_px);
  const std::uint16_t* line = buffer_.data() + y * format.channels.size() * width;
  float* silver = out.plane[3].data() + y * width;
  if (has_infrared()) {
    const std::uint16_t* in = line + static_cast<std::size_t>(infrared_plane_) * width;
    const float* table = tone_.table(3).data();
    for (std::size_t x = x0; x < x1; ++x) silver[x] = in[x] < kClipped ? table[in[x]] : 0.0F;
  } else {
    std::fill(silver + x0, silver + x1, 0.0F);
  }
  for (std::size_t c = 0; c < 3; ++c) {
    const std::uint16_t* in = line + static_cast<std::size_t>(rgb_plane_[c]) * width;
    const float* table = tone_.table(static_cast<int>(c)).data();
    float* to = out.plane[c].data() + y * width;
    for (std::size_t x = x0; x < x1; ++x) to[x] = table[in[x]];
    if (!has_infrared()) {
      const auto weight = static_cast<float>(weights_[c]);
      for (std::size_t x = x0; x < x1; ++x) silver[x] += weight * to[x];
    }
  }
  for (int plane : rgb_plane_) {
    const std::uint16_t* in = line + static_cast<std::size_t>(plane) * width;
    for (std::size_t x = x0; x < x1; ++x) silver[x] = in[x] < kClipped ? silver[x] : 0.0F;
  }
  for (std::size_t x = x0; x < x1; ++x) silver[x] = std::max(silver[x], 0.0F);
}

}  // namespace reseau
