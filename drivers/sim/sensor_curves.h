// How the lines of a two- or three-line sensor answer the same light.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "drivers/sim/wire_bytes.h"

namespace reseau::sim {

// Data type 91 as recorded from an LS-5000, one per colour R G B IR: for each of 2 sensor lines,
// for each of 2 curve types, 19 points of 16 bits, in hexadecimal.
inline constexpr int kCurvePoints = 19;
[[nodiscard]] std::string_view recorded_curves(std::size_t channel);

// Data type 91 of a unit whose lines differ this much (1: as recorded): per line, per type, points.
// Types beyond the two recorded ones repeat them.
[[nodiscard]] Bytes curve_data(std::size_t channel, int sensor_lines, int types, double strength);

// What the given sensor line reads where the first one reads value (both as fractions of full
// scale), by the recorded curves of type 1: through the common number of a point, straight between
// points, unchanged below the first, in proportion above the last. strength: 0 equal lines, 1 as
// recorded. Of a third line nothing is recorded; half of the second's difference stands in.
class LineResponse {
 public:
  LineResponse(std::size_t channel, int line, double strength);
  [[nodiscard]] float operator()(float value) const;

 private:
  std::array<float, kCurvePoints> from_{}, to_{};
  float share_;
};

}  // namespace reseau::sim
