// INQUIRY data. Source: LS-5000 interface specification, inquiry pages; recorded Nikon Scan
// session; LS-50 firmware 1.02.
#pragma once

#include <cstdint>
#include <optional>

#include "drivers/sim/unit_model.h"
#include "drivers/sim/wire_bytes.h"

namespace reseau::sim {

// What the adapter, or the holder, and the film in it change on the pages.
struct AdapterState {
  const UnitModel* model = nullptr;
  AdapterKind kind = AdapterKind::kSa21;
  bool film_present = false;
  int counted_frames = 0;  // 0 until a thumbnail was taken

  [[nodiscard]] bool holder() const { return !model->has_adapters; }
  [[nodiscard]] bool strip() const {
    return kind == AdapterKind::kSa21 || kind == AdapterKind::kSa30 || kind == AdapterKind::kAps;
  }
  [[nodiscard]] int capacity() const;
  // Page C1 [75].
  [[nodiscard]] int frames_present() const;
  [[nodiscard]] std::uint32_t frame_height() const;
  [[nodiscard]] std::uint32_t max_width() const;
  // X end that a window may reach: beyond the largest width where X can be cropped.
  [[nodiscard]] std::uint32_t x_end() const;
  // Page C1 [46-49]: largest window origin and height of a thumbnail.
  [[nodiscard]] std::uint32_t max_y_origin() const;
  // Where the holder's frame begins, and the film with it.
  [[nodiscard]] int holder_top() const;
};

// Operations that exist: two bytes per group 8x to Fx, as in page E1.
[[nodiscard]] Bytes operation_groups(const UnitModel& model, const AdapterState& adapter);
[[nodiscard]] Bytes standard_inquiry(const UnitModel& model);
// Empty when the unit does not have the page.
[[nodiscard]] std::optional<Bytes> vital_page(const UnitModel& model, const AdapterState& adapter,
                                              std::uint8_t code);

}  // namespace reseau::sim
