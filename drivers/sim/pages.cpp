#include "drivers/sim/pages.h"

#include <string_view>

namespace reseau::sim {
namespace {

// Every page begins 06 (scanner), code, length in two bytes.
Bytes page(std::uint8_t code, ByteView body) {
  Bytes result;
  put8(result, 0x06);
  put8(result, code);
  put16(result, static_cast<std::uint32_t>(body.size()));
  append(result, body);
  return result;
}

Bytes name_page(std::uint8_t code, std::string_view name) {
  Bytes body;
  put8(body, static_cast<std::uint32_t>(name.size() + 1));
  for (const char c : name) put8(body, static_cast<std::uint8_t>(c));
  put8(body, 0);
  return page(code, body);
}

Bytes page_list(const UnitModel& model, const AdapterState& adapter) {
  const char* const adapter_page = adapter.roll ? "47" : "46";
  const Bytes first = from_hex("00014041");
  const Bytes ls5000 = from_hex("5051606162C1D1E1E3F0F8E2FBFC");
  const Bytes ls50 = from_hex("50516061C1D1E1F0E2F8FBFC");
  Bytes body = first;
  append(body, from_hex(adapter_page));
  append(body, model.has_ccd_curves ? ls5000 : ls50);
  return page(0x00, body);
}

Bytes addresses_page(const UnitModel& model, const AdapterState& adapter) {
  Bytes p = from_hex(
      "06C10053 03 003D 000F 0000 0100 01 01 00 03 31 0FA0 0FA0 005A 00000000 00000000 00000000 "
      "00000F6A 0FA0 0FA0 005A 00000000 00000000 00000000 00001747 00001747 00000000 0061 0061 "
      "28 00 0000 0143 0000 10 0F6A 01 02");
  set16(p, 5, static_cast<std::uint32_t>(model.descriptor_list_bytes));
  if (!model.multi_reading) {
    set16(p, 11, 0x0040);
    p[16] = 0x01;
    p[85] = 0x00;
    p[86] = 0x01;
  }
  set32(p, 46, adapter.max_y_origin());
  p[74] = static_cast<std::uint8_t>(adapter.capacity());
  p[75] = static_cast<std::uint8_t>(adapter.frames_present());
  p[82] = static_cast<std::uint8_t>(model.adc_bits);
  return p;
}

// Pages no program interprets, as recorded.
std::optional<Bytes> service_page(const UnitModel& model, std::uint8_t code) {
  const bool ls5000 = model.has_ccd_curves;
  switch (code) {
    case 0xe2:
      return from_hex("06E2001A 01 B4 0000003C 00000E10 00000000 00000001 00000000 00000000");
    case 0xe3:
      if (!ls5000) return std::nullopt;
      return from_hex(
          "06E3002D 0701 0FA0 01 02 13 0000 0083 0106 0189 020C 028F 051F 0A3D 0CCC 1999 3333 4CCC "
          "6666 7FFF 9999 B332 CCCC E665 F332");
    case 0xf0:
      return from_hex(
          "06F00031 0340 0000 0000 0000 1E67 09C4 1770 0100 1241 0000 0000 0000 024A 0258 0258 "
          "0100 0647 0000 0000 0000 1E68 012C 04B0 0100 05");
    case 0xf8:
      return from_hex(ls5000 ? "06F8000D 63055002510260046101620100"
                             : "06F8000B 6304500151016004610100");
    case 0xfb:
      return from_hex("06FB000D 06010802080308040805100604");
    case 0xfc:
      return from_hex("06FC0004 01010100");
    default:
      return std::nullopt;
  }
}

}  // namespace

Bytes standard_inquiry(const UnitModel& model) {
  Bytes reply = from_hex("06 80 02 02 1F 00 00 00");
  const auto text = [&reply](std::string_view words, std::size_t length) {
    for (std::size_t i = 0; i < length; ++i) {
      put8(reply, i < words.size() ? static_cast<std::uint8_t>(words[i]) : ' ');
    }
  };
  text("Nikon", 8);
  text(model.product, 16);
  text(model.revision, 4);
  return reply;
}

std::optional<Bytes> vital_page(const UnitModel& model, const AdapterState& adapter,
                                std::uint8_t code) {
  switch (code) {
    case 0x00:
      return page_list(model, adapter);
    case 0x01:
      return name_page(code, adapter.roll ? "36Strip" : "6Strip");
    case 0x40:
      return name_page(code, "SCAN Motor");
    case 0x41:
      return name_page(code, "AF Motor");
    case 0x50:
      return name_page(code, "DA_COARSE");
    case 0x51:
      return name_page(code, "DA_FINE");
    case 0x60:
      return name_page(code, "EXP_TIME");
    case 0x61:
      return name_page(code, "GAIN");
    case 0xc1:
      return addresses_page(model, adapter);
    case 0xd1:
      return from_hex(model.page_d1);
    case 0xe1:
      return from_hex(model.page_e1);
    default:
      return service_page(model, code);
  }
}

}  // namespace reseau::sim
