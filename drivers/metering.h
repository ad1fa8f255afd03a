// The arithmetic of exposure metering, for units that leave it to the host.
// Locked, red, green and blue keep the ratios of the unit's own white balance, so that the balance
// of the film's colour screen stays as it is; unlocked, each goes to its own target, as for colour
// negatives. Infrared is metered by itself. The sensor is linear in exposure, therefore one
// proportional step reaches the target from any unclipped measurement. Pure, reentrant.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace reseau {

// Red, green, blue, infrared, in steps of the unit's own timer.
using Exposures = std::array<std::uint32_t, 4>;

// Counts samples of the planes of one pass.
class LevelHistogram {
 public:
  explicit LevelHistogram(int n_channels);
  // Samples in line format: [channel][pixel].
  void add_line(std::span<const std::uint16_t> line);
  // The level that all but 0.1 % of the samples stay below or at, 0 to 1. Absent before any sample.
  [[nodiscard]] std::optional<double> high_level(int channel) const;

 private:
  std::vector<std::vector<std::uint32_t>> counts_;  // [channel][level / 16]
};

// High levels of red, green, blue, infrared; absent channels were not measured.
using Levels = std::array<std::optional<double>, 4>;

struct ExposureLimits {
  std::uint32_t min = 1;
  std::uint32_t max = 0x03FFFFFF;
};

// Factors on the white-balance exposures, improved from pass to pass.
class Metering {
 public:
  Metering(const Exposures& white_balance, ExposureLimits limits, bool lock = true);

  [[nodiscard]] Exposures exposures() const;
  // Takes the levels that a pass with exposures() gave. True when no further pass is needed: no
  // channel clipped and the step was small enough to be exact.
  bool improve(const Levels& levels);
  // As the last pass, for a person who asks for more or less light.
  void multiply(double factor);

 private:
  struct Step {
    double factor;
    bool exact;
  };
  [[nodiscard]] Step step_for(double level) const;
  // Channels [first, last) share a factor.
  struct Group {
    std::size_t first, last;
    double scale = 1.0;
  };
  [[nodiscard]] double limited(double scale, const Group& group) const;
  [[nodiscard]] bool improve(Group& group, const Levels& levels) const;

  Exposures white_balance_;
  ExposureLimits limits_;
  std::vector<Group> groups_;
};

}  // namespace reseau
