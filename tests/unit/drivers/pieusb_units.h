// INQUIRY and other replies of units of the PIE family, built by hand.
#pragma once

#include <string_view>

#include "drivers/bytes.h"
#include "drivers/pieusb/plan.h"

namespace reseau::pieusb {

inline Bytes pie_inquiry(int model, int dpi, int width_px, int height_px, bool confirms) {
  Bytes b(184, std::byte{0});
  const auto put16 = [&](std::size_t at, int value) {
    b[at] = std::byte(value & 0xFF);
    b[at + 1] = std::byte(value >> 8);
  };
  const auto text = [&](std::size_t at, std::string_view s) {
    for (std::size_t i = 0; i < s.size(); ++i) b[at + i] = std::byte(s[i]);
  };
  b[4] = std::byte{180};
  text(8, "PIE     ");
  text(16, "MF Scanner      ");
  text(32, "1.70");
  text(96, "1.70");
  put16(36, dpi);
  put16(38, dpi);
  put16(40, width_px);
  put16(42, height_px);
  b[44] = std::byte{0x9E};
  b[45] = std::byte{0x35};
  b[46] = std::byte{0x07};
  b[50] = std::byte(confirms ? 0x04 : 0x02);
  put16(104, 0xFFFF);
  put16(106, 100);
  put16(112, width_px);
  put16(114, height_px);
  put16(116, model);
  return b;
}

inline UnitDescription pie_unit(int model, int dpi, int width_px, int height_px) {
  UnitDescription unit;
  unit.model = *model_by_number(model);
  unit.inquiry = parse_inquiry(
      pie_inquiry(model, dpi, width_px, height_px, unit.model.transport != Transport::kNone));
  return unit;
}

inline std::vector<UnitDescription> pie_units() {
  return {pie_unit(0x2E, 3600, 5172, 3444),  pie_unit(0x30, 7200, 6660, 10206),
          pie_unit(0x36, 7200, 6660, 10206), pie_unit(0x47, 10000, 9240, 14170),
          pie_unit(0x2F, 3600, 5172, 3444),  pie_unit(0x3A, 5000, 7180, 4780),
          pie_unit(0x31, 7200, 10344, 6888)};
}

}  // namespace reseau::pieusb
