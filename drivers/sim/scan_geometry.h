// Where on the film a sample is centred: errors of the stage, stagger of the sensor's lines, lens
// distortion and lateral colour.
#pragma once

#include <cstdint>

#include "drivers/sim/optics_spec.h"
#include "drivers/sim/stage.h"

namespace reseau::sim {

struct ScanPlace {
  double x = 0, y = 0;
};

// Which line of the sensor exposes the optical line at y, and where the stage should be meanwhile.
// n sensor lines lie gap lines apart; gap exposures fill a block of n * gap lines.
struct SensorLine {
  int index = 0;
  double stage_y = 0;
};
[[nodiscard]] SensorLine sensor_line(double y, const SensorSpec& sensor);

// Scan coordinates are nominal optical pixels: what a perfect scanner would look at. Immutable,
// thread-safe.
class ScanGeometry {
 public:
  // The perfect scanner.
  ScanGeometry();
  // field_px: pixels of the lens's field, from pixel 0 on; seed: of the stage's random errors.
  ScanGeometry(const OpticsSpec& optics, const StageSpec& stage, const SensorSpec& sensor,
               int field_px, std::uint64_t seed);

  // Where sample (x, y) really looks; without a channel, lateral colour left out.
  [[nodiscard]] ScanPlace place(double x, double y) const;
  [[nodiscard]] ScanPlace place(int channel, double x, double y) const;
  // The two parts of place(): x through the lens, and the displacement of the line.
  [[nodiscard]] double through_lens(int channel, double x) const;
  [[nodiscard]] StageError line_error(double y) const;
  // Distance from the axis, 1 at the end of the field.
  [[nodiscard]] double rho(double x) const { return (x - axis_px_) / half_px_; }
  [[nodiscard]] int field_px() const { return field_px_; }

  [[nodiscard]] bool is_perfect() const { return is_perfect_; }
  // What no displacement exceeds, per axis.
  [[nodiscard]] ScanPlace largest() const;

 private:
  [[nodiscard]] double distorted(double x) const;

  OpticsSpec optics_;
  SensorSpec sensor_;
  Stage stage_;
  int field_px_;
  double axis_px_, half_px_;
  bool is_perfect_;
};

}  // namespace reseau::sim
