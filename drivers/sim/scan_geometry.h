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

// Scan coordinates are nominal optical pixels: what a perfect scanner would look at. Immutable,
// thread-safe.
class ScanGeometry {
 public:
  // The perfect scanner.
  ScanGeometry();
  // seed: of the stage's random errors.
  ScanGeometry(const StageSpec& stage, std::uint64_t seed);

  // Where sample (x, y) really looks.
  [[nodiscard]] ScanPlace place(double x, double y) const;
  [[nodiscard]] bool is_perfect() const { return !stage_.moves(); }
  // What no displacement exceeds, per axis.
  [[nodiscard]] ScanPlace largest() const;

 private:
  Stage stage_;
};

}  // namespace reseau::sim
