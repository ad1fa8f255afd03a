// From what a person asks and what a unit says it can, to a plan. Pure arithmetic, no device.
#pragma once

#include <string>

#include "drivers/pieusb/commands.h"
#include "drivers/pieusb/models.h"
#include "drivers/pieusb/replies.h"
#include "drivers/scan_plan.h"
#include "drivers/scanner.h"

namespace reseau::pieusb {

// The unit's timer wraps above this, and the picture gets darker.
inline constexpr int kMaxExposure = 65535;
inline constexpr double kExposureStepUs = 1.085;

// Everything known of one unit. Plain value.
struct UnitDescription {
  Model model;
  Inquiry inquiry;
  std::string serial, link;
  bool film_present = true;
};

[[nodiscard]] Capabilities capabilities_of(const UnitDescription& unit);

// Pixels of the highest resolution per delivered pixel; the highest resolution is a whole multiple
// of every one that is offered, so that no resolution comes out coarser than asked.
[[nodiscard]] int pitch_for(const Inquiry& inquiry, int resolution_dpi);

// Throws InputError when nothing near the request is possible.
[[nodiscard]] Negotiated negotiate(const ScanRequest& request, const UnitDescription& unit);

// The frame that SCAN FRAME shall get; inside the unit's scan area for every plan of negotiate().
[[nodiscard]] ScanFrame frame_of(const ScanPlan& plan, const UnitDescription& unit);

}  // namespace reseau::pieusb
