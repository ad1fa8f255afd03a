#pragma once

#include <cstdint>
#include <optional>
#include <stop_token>
#include <vector>

#include "drivers/metering.h"
#include "drivers/pieusb/line_sorter.h"
#include "drivers/pieusb/plan.h"
#include "drivers/pieusb/shading.h"
#include "drivers/pieusb/unit.h"

namespace reseau::pieusb {

// What one pass over the film shall take.
struct PassSpec {
  ScanFrame frame;
  int dpi = 0;
  int width_px = 0, n_lines = 0;  // delivered
  int depth_bits = 16;
  bool infrared = true;
  Exposures exposures{};  // steps of the unit's timer
};

// The calibration that the host holds, and what it was taken with.
struct HeldReference {
  ShadingReference reference;
  Exposures exposures{};
};

// Both are kept from pass to pass.
struct PassMemory {
  CalibrationInfo calibration_info;
  GainReference gain;
  std::optional<HeldReference> held;
};

// One pass: set up and started by start(), calibrated, read row by row. What is left of it when
// this is destroyed stays in the unit until Unit::finish_pass(). Thread-bound; borrows unit and
// memory.
class ScanPass {
 public:
  // Absent when stopped before the scan began. fresh_calibration: the reference has to belong to
  // these very exposures where the unit can take it along. Throws DeviceError.
  [[nodiscard]] static std::optional<ScanPass> start(Unit& unit, const UnitDescription& description,
                                                     PassMemory& memory, const PassSpec& spec,
                                                     bool fresh_calibration,
                                                     const std::stop_token& stop);

  // Writes at least one row, [row][channel][pixel], evened out, to the front of samples; returns
  // how many, 0 at the end only. samples grows to what is needed. Throws DeviceError.
  int read(std::vector<std::uint16_t>& samples);
  [[nodiscard]] const Shading& shading() const { return shading_; }

 private:
  ScanPass(Unit& unit, const PassSpec& spec, int wire_width_px, int wire_lines);

  Unit* unit_;
  int width_px_, n_channels_;
  int rows_left_;
  LineSorter sorter_;
  Shading shading_;
};

}  // namespace reseau::pieusb
