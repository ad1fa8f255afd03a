// INQUIRY data. Source: LS-5000 interface specification, inquiry pages; recorded Nikon Scan
// session; LS-50 firmware 1.02.
#pragma once

#include <cstdint>
#include <optional>

#include "drivers/sim/unit_model.h"
#include "drivers/sim/wire_bytes.h"

namespace reseau::sim {

// What the strip adapter and the film in it change on the pages.
struct AdapterState {
  bool roll = false;  // SA-30; otherwise SA-21
  bool film_present = false;
  int counted_frames = 0;  // 0 until a thumbnail was taken

  [[nodiscard]] int capacity() const { return roll ? 40 : 6; }
  // Page C1 [75].
  [[nodiscard]] int frames_present() const {
    if (!film_present) return 0;
    return counted_frames > 0 ? counted_frames : capacity();
  }
  // Page C1 [46-49]: largest window origin and height of a thumbnail.
  [[nodiscard]] std::uint32_t max_y_origin() const {
    if (!film_present) return 0;
    return static_cast<std::uint32_t>((frames_present() + 2) * kFrameHeightPx);
  }
};

[[nodiscard]] Bytes standard_inquiry(const UnitModel& model);
// Empty when the unit does not have the page.
[[nodiscard]] std::optional<Bytes> vital_page(const UnitModel& model, const AdapterState& adapter,
                                              std::uint8_t code);

}  // namespace reseau::sim
