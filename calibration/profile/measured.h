#pragma once

namespace reseau {

// A number that was measured, and its standard deviation.
struct Measured {
  double value = 0, sd = 0;
  bool operator==(const Measured&) const = default;
};

}  // namespace reseau
