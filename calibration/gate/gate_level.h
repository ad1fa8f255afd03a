// One channel of one scan of an open frame, reduced to what later steps need. Part of measure_gate.
#pragma once

#include <cstddef>
#include <vector>

#include "calibration/gate/gate.h"

namespace reseau::gate {

struct Reduced {
  GateLevel level;
  std::vector<double> columns;  // mean of each pixel over the lines
  double column_sd = 0;         // of one of them
  std::vector<double> lines;    // mean of each line
};

[[nodiscard]] Reduced reduce(const GateScan& scan, std::size_t channel);

}  // namespace reseau::gate
