// From what a person asks and what a unit says it can, to a plan. Pure arithmetic, no device.
#pragma once

#include <string>
#include <vector>

#include "drivers/coolscan/frames.h"
#include "drivers/coolscan/models.h"
#include "drivers/coolscan/pages.h"
#include "drivers/scan_plan.h"
#include "drivers/scanner.h"

namespace reseau::coolscan {

// Everything known of one unit with its adapter and film. Plain value.
struct UnitDescription {
  StandardInquiry inquiry;
  std::string serial, adapter, link;
  bool infrared = false;
  bool film_present = false;
  AddressPage addresses;
  WindowPage windows;
  DutyPage duties;
  Errata errata;
  std::vector<FrameRecord> strip;      // the unit's table of frames of a strip; empty: none
  std::vector<FrameRectangle> holder;  // frames of a holder; empty: not published
  bool frames_found = false;           // on the film itself
};

// Every frame there is, absolute. Where the unit publishes none, one each max_height_px.
[[nodiscard]] std::vector<FrameRectangle> frames_of(const UnitDescription& unit);
[[nodiscard]] std::vector<int> depths_of(const UnitDescription& unit);
// Readings of a line that may be asked for.
[[nodiscard]] int max_readings(const UnitDescription& unit);
[[nodiscard]] bool has_thumbnails(const UnitDescription& unit);
// The record of a strip's frame, moved so that it stays on the film.
[[nodiscard]] FrameRecord moved_on_film(const UnitDescription& unit, const FrameRecord& frame,
                                        int by_px);

[[nodiscard]] Capabilities capabilities_of(const UnitDescription& unit);

// Optical pixels per delivered pixel for a resolution: truncating division, then the next lower
// pitch that the unit's rule allows, so that no resolution comes out coarser than asked.
// Source: LS-5000 interface specification, SET WINDOW; ladder of a recorded session.
[[nodiscard]] int pitch_for(const AddressPage& addresses, int resolution_dpi);

// Throws InputError when nothing near the request is possible.
[[nodiscard]] Negotiated negotiate(const ScanRequest& request, const UnitDescription& unit);

// False when the adapter or the film changed so that the plan would leave the unit's boundary or
// ask for what the unit does not offer.
[[nodiscard]] bool still_fits(const ScanPlan& plan, const UnitDescription& unit);

}  // namespace reseau::coolscan
