// A scan with what the unit's pixels add and take away undone: dark level and flat field, as a
// calibration measured them. Thread-safe where the source is.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/line/line_source.h"

namespace reseau {

// Red, green, blue, infrared. Plain value; what was not measured changes nothing.
struct LevelCorrection {
  std::array<double, 4> dark_level{};            // of full scale
  std::array<std::vector<double>, 4> flat_gain;  // per pixel of a whole line

  [[nodiscard]] bool empty() const;
  // Whether a line of so many pixels is one of those that the gains are for.
  [[nodiscard]] bool fits(int width_px) const;
};

// Samples become (sample - dark) * gain, rounded, between 0 and full scale. Gains of a line of
// another width are left out: nobody knows which of its pixels these are.
class CorrectedLines final : public LineSource {
 public:
  // `source` must outlive this. Samples must be linear in light.
  CorrectedLines(const LineSource& source, const LevelCorrection& correction);

  [[nodiscard]] const LineFormat& format() const override { return source_.format(); }
  [[nodiscard]] int committed() const override { return source_.committed(); }
  int wait_committed(int n_lines, const std::stop_token& stop) const override {
    return source_.wait_committed(n_lines, stop);
  }
  void read(int first, int n, std::span<std::uint16_t> out) const override;

 private:
  const LineSource& source_;
  std::vector<float> dark_;               // per plane, in counts
  std::vector<std::vector<float>> gain_;  // per plane; empty = 1
};

}  // namespace reseau
