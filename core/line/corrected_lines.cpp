#include "core/line/corrected_lines.h"

#include <algorithm>
#include <cstddef>

namespace reseau {
namespace {

constexpr float kFullScale = 65535.0F;

}  // namespace

bool LevelCorrection::empty() const {
  return std::ranges::all_of(dark_level, [](double level) { return level == 0; }) &&
         std::ranges::all_of(flat_gain, [](const auto& gains) { return gains.empty(); });
}

bool LevelCorrection::fits(int width_px) const {
  bool any = false;
  for (const std::vector<double>& gains : flat_gain) {
    if (gains.empty()) continue;
    if (gains.size() != static_cast<std::size_t>(width_px)) return false;
    any = true;
  }
  return any;
}

CorrectedLines::CorrectedLines(const LineSource& source, const LevelCorrection& correction)
    : source_(source) {
  constexpr std::array kOrder{Channel::kRed, Channel::kGreen, Channel::kBlue, Channel::kInfrared};
  const LineFormat& format = source.format();
  const bool flat = correction.fits(format.width_px);
  for (const Channel channel : format.channels) {
    const auto at = std::ranges::find(kOrder, channel);
    dark_.push_back(0);
    gain_.emplace_back();
    if (at == kOrder.end()) continue;
    const auto c = static_cast<std::size_t>(at - kOrder.begin());
    dark_.back() = static_cast<float>(correction.dark_level[c]) * kFullScale;
    if (!flat) continue;
    for (const double gain : correction.flat_gain[c]) {
      gain_.back().push_back(static_cast<float>(gain));
    }
  }
}

void CorrectedLines::read(int first, int n, std::span<std::uint16_t> out) const {
  source_.read(first, n, out);
  const auto width = static_cast<std::size_t>(format().width_px);
  for (std::size_t at = 0, plane = 0; at + width <= out.size();
       at += width, plane = (plane + 1) % dark_.size()) {
    const float dark = dark_[plane];
    const std::vector<float>& gain = gain_[plane];
    if (dark == 0 && gain.empty()) continue;
    for (std::size_t i = 0; i < width; ++i) {
      const float light =
          (static_cast<float>(out[at + i]) - dark) * (gain.empty() ? 1.0F : gain[i]);
      out[at + i] = static_cast<std::uint16_t>(std::clamp(light + 0.5F, 0.0F, kFullScale));
    }
  }
}

}  // namespace reseau
