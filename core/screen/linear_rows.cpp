#include "core/screen/linear_rows.h"

#include <algorithm>
#include <cmath>

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
  infrared_plane_ = format.plane_of(Channel::kInfrared);
  if (std::ranges::min(rgb_plane_) < 0) {
    const int grey = format.plane_of(Channel::kGrey);
    grey_plane_ = grey >= 0 ? grey : infrared_plane_;
    CHECK(grey_plane_ >= 0);
  }
}

void LinearReader::read(int first, int n, LinearRows& out) {
  const LineFormat& format = source_.format();
  const auto width = static_cast<std::size_t>(format.width_px);
  const auto n_channels = format.channels.size();
  buffer_.resize(format.samples_per_line() * static_cast<std::size_t>(n));
  source_.read(first, n, buffer_);
  out.first = first;
  out.n = n;
  out.width_px = format.width_px;
  out.grey = grey();
  for (auto& plane : out.plane) plane.resize(width * static_cast<std::size_t>(n));
  if (grey()) return take_grey(out);
  for (std::size_t y = 0; y < static_cast<std::size_t>(n); ++y) {
    const std::uint16_t* line = buffer_.data() + y * n_channels * width;
    float* silver = out.plane[3].data() + y * width;
    if (has_infrared()) {
      const std::uint16_t* in = line + static_cast<std::size_t>(infrared_plane_) * width;
      const float* table = tone_.table(3).data();
      for (std::size_t x = 0; x < width; ++x) silver[x] = in[x] < kClipped ? table[in[x]] : 0.0F;
    } else {
      std::fill_n(silver, width, 0.0F);
    }
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint16_t* in = line + static_cast<std::size_t>(rgb_plane_[c]) * width;
      const float* table = tone_.table(static_cast<int>(c)).data();
      float* to = out.plane[c].data() + y * width;
      for (std::size_t x = 0; x < width; ++x) to[x] = table[in[x]];
      if (!has_infrared()) {
        const auto weight = static_cast<float>(weights_[c]);
        for (std::size_t x = 0; x < width; ++x) silver[x] += weight * to[x];
      }
    }
    for (int plane : rgb_plane_) {
      const std::uint16_t* in = line + static_cast<std::size_t>(plane) * width;
      for (std::size_t x = 0; x < width; ++x) silver[x] = in[x] < kClipped ? silver[x] : 0.0F;
    }
    for (std::size_t x = 0; x < width; ++x) silver[x] = std::max(silver[x], 0.0F);
  }
}

void LinearReader::take_grey(LinearRows& out) const {
  // Black film shows 0.003 of full scale and noise.
  constexpr float kPerBlack = 500;
  const auto width = static_cast<std::size_t>(out.width_px);
  const std::size_t n_channels = source_.format().channels.size();
  const float* table = tone_.table(std::min(grey_plane_, 3)).data();
  for (std::size_t c = 1; c < 4; ++c) std::ranges::fill(out.plane[c], 1.0F);
  for (std::size_t y = 0; y < static_cast<std::size_t>(out.n); ++y) {
    const std::uint16_t* in =
        buffer_.data() + (y * n_channels + static_cast<std::size_t>(grey_plane_)) * width;
    float* to = out.plane[0].data() + y * width;
    float* silver = out.plane[3].data() + y * width;
    for (std::size_t x = 0; x < width; ++x) {
      to[x] = std::log1p(kPerBlack * std::max(table[in[x]], 0.0F));
      if (in[x] >= kClipped) silver[x] = 0;
    }
  }
}

}  // namespace reseau
