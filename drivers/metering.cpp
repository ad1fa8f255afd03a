#include "drivers/metering.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"

namespace reseau {
namespace {

// Head room for what the metering pass did not see: a pixel of the final pass can be brighter than
// the average of a coarser one.
constexpr double kTarget = 0.90;
// From this level on a sample may have been cut off.
constexpr double kClipped = 0.995;
constexpr double kIgnoredShare = 0.001;
// Beyond this a measurement is too dark for its own noise: step, then look again.
constexpr double kMaxExactStep = 4.0;
constexpr double kMaxStep = 16.0;
constexpr int kLevelsPerBin = 16;
constexpr std::size_t kBins = 65536 / kLevelsPerBin;

}  // namespace

LevelHistogram::LevelHistogram(int n_channels)
    : counts_(static_cast<std::size_t>(n_channels), std::vector<std::uint32_t>(kBins)) {}

void LevelHistogram::add_line(std::span<const std::uint16_t> line) {
  CHECK(line.size() % counts_.size() == 0);
  const std::size_t width = line.size() / counts_.size();
  for (std::size_t c = 0; c < counts_.size(); ++c) {
    for (const std::uint16_t sample : line.subspan(c * width, width)) {
      ++counts_[c][sample / kLevelsPerBin];
    }
  }
}

std::optional<double> LevelHistogram::high_level(int channel) const {
  const std::vector<std::uint32_t>& counts = counts_[static_cast<std::size_t>(channel)];
  std::uint64_t total = 0;
  for (const std::uint32_t count : counts) total += count;
  if (total == 0) return std::nullopt;
  const auto ignored = static_cast<std::uint64_t>(static_cast<double>(total) * kIgnoredShare);
  std::uint64_t above = 0;
  std::size_t bin = kBins - 1;
  while (bin > 0 && above + counts[bin] <= ignored) above += counts[bin--];
  return static_cast<double>((bin + 1) * kLevelsPerBin - 1) / 65535.0;
}

Metering::Metering(const Exposures& white_balance, ExposureLimits limits)
    : white_balance_(white_balance), limits_(limits) {
  for (std::uint32_t& exposure : white_balance_) exposure = std::max<std::uint32_t>(exposure, 1);
  visible_scale_ = limited(visible_scale_, 0, 3);
  infrared_scale_ = limited(infrared_scale_, 3, 4);
}

Exposures Metering::exposures() const {
  Exposures result{};
  for (std::size_t i = 0; i < result.size(); ++i) {
    const double exposure = white_balance_[i] * (i < 3 ? visible_scale_ : infrared_scale_);
    result[i] =
        std::clamp(static_cast<std::uint32_t>(std::lround(exposure)), limits_.min, limits_.max);
  }
  return result;
}

// Keeps every exposure of [first, last) below the maximum, with their ratios.
double Metering::limited(double scale, std::size_t first, std::size_t last) const {
  for (std::size_t i = first; i < last; ++i) {
    scale = std::min(scale, static_cast<double>(limits_.max) / white_balance_[i]);
  }
  return scale;
}

Metering::Step Metering::step_for(double level) const {
  // How far a clipped channel is off is unknown: halve and look again.
  if (level >= kClipped) return {0.5, false};
  const double factor = kTarget / std::max(level, kTarget / kMaxStep);
  return {factor, factor <= kMaxExactStep};
}

bool Metering::improve(const Levels& levels) {
  bool done = true;
  double visible = kMaxStep;
  bool measured = false;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!levels[i]) continue;
    const Step step = step_for(*levels[i]);
    measured = true;
    // The brightest channel decides for all three.
    if (step.factor < visible) {
      visible = step.factor;
      done = step.exact;
    }
  }
  const auto apply = [&](double& scale, double factor, std::size_t first, std::size_t last) {
    const double before = scale;
    scale = limited(scale * factor, first, last);
    return scale != before;
  };
  if (measured && !apply(visible_scale_, visible, 0, 3)) done = true;
  if (levels[3]) {
    const Step step = step_for(*levels[3]);
    if (apply(infrared_scale_, step.factor, 3, 4)) done = done && step.exact;
  }
  return done;
}

void Metering::multiply(double factor) {
  visible_scale_ = limited(visible_scale_ * factor, 0, 3);
  infrared_scale_ = limited(infrared_scale_ * factor, 3, 4);
}

}  // namespace reseau
