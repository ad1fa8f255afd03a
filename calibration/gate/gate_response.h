// Level against the exposures of all channels. Part of measure_gate.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "calibration/gate/gate.h"

namespace reseau::gate {

// A channel's level in one scan, and the exposures of all channels in it.
struct Exposed {
  double level = 0, level_sd = 0;
  std::array<std::optional<double>, kGateChannels> exposure_us;
};

// Fills dark, nonlinearity and leakage of `out` as far as the scans tell. Needs the channel's own
// exposure in each; `first`: the exposures that leakage is told at.
void fit_response(const std::vector<Exposed>& scans, std::size_t channel,
                  const std::array<std::optional<double>, kGateChannels>& first, GateChannel& out);

// Straight line of variance against light, weighted.
[[nodiscard]] std::optional<GateNoise> fit_noise(const std::vector<GateLevel>& levels, double dark);

}  // namespace reseau::gate
