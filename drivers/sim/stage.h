// Where the scanner's stage really stands when it should be at a line.
#pragma once

#include <cstdint>

#include "drivers/sim/optics_spec.h"

namespace reseau::sim {

// Displacement of a line on the film against its nominal place [optical px]: x along the sensor,
// y along the motion.
struct StageError {
  double x = 0, y = 0;
};

// Immutable, thread-safe. The error of a line depends on the seed and the line's place alone.
class Stage {
 public:
  Stage(const StageSpec& spec, std::uint64_t seed);

  // y: nominal place of the line in optical px, any value. At whole y the random part is that
  // of the line, between them it is interpolated linearly.
  [[nodiscard]] StageError error_at(double y) const;
  // False for a stage that never errs.
  [[nodiscard]] bool moves() const { return moves_; }
  // What no error exceeds, per axis (of random parts: six standard deviations over 10^5 lines).
  [[nodiscard]] StageError largest() const;

 private:
  [[nodiscard]] double random_part(std::int64_t line) const;

  StageSpec spec_;
  std::uint64_t seed_;
  bool moves_;
};

}  // namespace reseau::sim
