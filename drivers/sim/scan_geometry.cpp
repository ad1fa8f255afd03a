#include "drivers/sim/scan_geometry.h"

namespace reseau::sim {

ScanGeometry::ScanGeometry() : ScanGeometry(StageSpec{}, 0) {}

ScanGeometry::ScanGeometry(const StageSpec& stage, std::uint64_t seed) : stage_(stage, seed) {}

ScanPlace ScanGeometry::place(double x, double y) const {
  const StageError error = stage_.error_at(y);
  return {x + error.x, y + error.y};
}

ScanPlace ScanGeometry::largest() const {
  const StageError error = stage_.largest();
  return {error.x, error.y};
}

}  // namespace reseau::sim
