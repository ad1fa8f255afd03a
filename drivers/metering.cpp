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

Metering::Metering(const Exposures& white_balance, ExposureLimits limits, bool lock)
    : white_balance_(white_balance), limits_(limits) {
  for (std::uint32_t& exposure : white_balance_) exposure = std::max<std::uint32_t>(exposure, 1);
  if (lock) {
    groups_ = {{0, 3}, {3, 4}};
  } else {
    groups_ = {{0, 1}, {1, 2}, {2, 3}, {3, 4}};
  }
  for (Group& group : groups_) group.scale = limited(group.scale, group);
}

Exposures Metering::exposures() const {
  Exposures result{};
  for (const Group& group : groups_) {
    for (std::size_t i = group.first; i < group.last; ++i) {
      result[i] =
          std::clamp(static_cast<std::uint32_t>(std::lround(white_balance_[i] * group.scale)),
                     limits_.min, limits_.max);
    }
  }
  return result;
}

// Keeps every exposure of the group below the maximum, with their ratios.
double Metering::limited(double scale, const Group& group) const {
  for (std::size_t i = group.first; i < group.last; ++i) {
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

bool Metering::improve(Group& group, const Levels& levels) const {
  double factor = kMaxStep;
  bool done = true, measured = false;
  for (std::size_t i = group.first; i < group.last; ++i) {
    if (!levels[i]) continue;
    const Step step = step_for(*levels[i]);
    measured = true;
    // The brightest channel decides for all of the group.
    if (step.factor < factor) {
      factor = step.factor;
      done = step.exact;
    }
  }
  if (!measured) return true;
  const double before = group.scale;
  group.scale = limited(group.scale * factor, group);
  return group.scale == before || done;
}

bool Metering::improve(const Levels& levels) {
  bool done = true;
  for (Group& group : groups_) {
    if (!improve(group, levels)) done = false;
  }
  return done;
}

void Metering::multiply(double factor) {
  for (Group& group : groups_) group.scale = limited(group.scale * factor, group);
}

}  // namespace reseau
