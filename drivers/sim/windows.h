// The scan windows of a unit: SET WINDOW, GET WINDOW. Source: LS-5000 interface specification,
// windows; recorded Nikon Scan session; LS-50 firmware 1.02.
#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "drivers/sim/pages.h"
#include "drivers/sim/sense.h"
#include "drivers/sim/unit_model.h"
#include "drivers/sim/wire_bytes.h"

namespace reseau::sim {

// A stored descriptor with its fields by name. Lengths in measurement units.
struct Window {
  Bytes raw;  // 50 bytes

  [[nodiscard]] int id() const { return raw[0]; }
  [[nodiscard]] int x_dpi() const { return static_cast<int>(get16(raw, 2)); }
  [[nodiscard]] std::uint32_t x_origin() const { return get32(raw, 6); }
  [[nodiscard]] std::uint32_t y_origin() const { return get32(raw, 10); }
  [[nodiscard]] std::uint32_t width() const { return get32(raw, 14); }
  [[nodiscard]] std::uint32_t height() const { return get32(raw, 18); }
  [[nodiscard]] int composition() const { return raw[25]; }
  [[nodiscard]] int depth_bits() const { return raw[26]; }
  // 1 unless both the count and the mode ask for more.
  [[nodiscard]] int readings() const { return (raw[43] & 0x10) != 0 ? (raw[40] >> 4) + 1 : 1; }
  [[nodiscard]] bool thumbnail() const { return raw[42] == 0x02; }
  [[nodiscard]] bool multi_line() const { return raw[44] == 0x40; }
  [[nodiscard]] std::uint32_t exposure() const { return get32(raw, 46); }
};

// 0 default, 1 red, 2 green, 3 blue, 4 grey, 9 infrared.
class WindowStore {
 public:
  explicit WindowStore(const UnitModel& model);

  // Data of SET WINDOW. mud: measurement units per inch. Returns kRounded when the resolution was
  // changed; anything worse leaves the windows as they were.
  [[nodiscard]] Sense set(ByteView list, const AdapterState& adapter, int mud, bool infrared_bit);
  // One window, or all without grey. Empty for an id that does not exist.
  [[nodiscard]] std::optional<Bytes> reply_one(int id) const;
  [[nodiscard]] Bytes reply_all() const;
  // Nullptr for an id that does not exist.
  [[nodiscard]] const Window* find(int id) const;

 private:
  [[nodiscard]] Sense check(Window& window, const AdapterState& adapter, int mud) const;
  void append_descriptor(Bytes& to, const Window& window) const;
  const UnitModel* model_;
  std::map<int, Window> windows_;
};

// Optical pixels per delivered pixel for a resolution, by the ladder of the model.
[[nodiscard]] int pitch_for_dpi(const UnitModel& model, int dpi);

}  // namespace reseau::sim
