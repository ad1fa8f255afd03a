#include "drivers/sim/pages.h"

#include <string>
#include <string_view>

namespace reseau::sim {
namespace {

// Every page begins 06 (scanner), code, length in two bytes.
Bytes page(std::uint8_t code, ByteView body) {
  Bytes result;
  result.reserve(4 + body.size());
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

std::string_view adapter_page_code(AdapterKind kind) {
  switch (kind) {
    case AdapterKind::kSa30:
      return "47";
    case AdapterKind::kAps:
      return "43";
    case AdapterKind::kFeeder:
      return "45";
    case AdapterKind::kMount:
      return "10";
    default:
      return "46";
  }
}

std::string_view adapter_name(const AdapterState& adapter) {
  if (adapter.holder()) return "SL-1";
  switch (adapter.kind) {
    case AdapterKind::kSa30:
      return "36Strip";
    case AdapterKind::kAps:
      return "240";
    case AdapterKind::kFeeder:
      return "Feeder";
    case AdapterKind::kMount:
      return "Mount";
    default:
      return "6Strip";
  }
}

Bytes page_list(const UnitModel& model, const AdapterState& adapter) {
  if (adapter.kind == AdapterKind::kNone) return page(0x00, from_hex("00C1FBFC"));
  std::string codes(model.page_list);
  const std::size_t mark = codes.find("AA");
  if (mark != std::string::npos) codes.replace(mark, 2, adapter_page_code(adapter.kind));
  Bytes body = from_hex(codes);
  // The unload timer's page belongs to strip film.
  if (!adapter.holder() && !adapter.strip()) std::erase(body, std::uint8_t{0xe2});
  return page(0x00, body);
}

Bytes addresses_page(const UnitModel& model, const AdapterState& adapter) {
  Bytes p = from_hex(model.page_c1);
  set16(p, 5, static_cast<std::uint32_t>(model.descriptor_list_bytes));
  if (adapter.holder()) return p;
  if (adapter.kind == AdapterKind::kNone) {
    p[3] = 12;  // ends before any address
    p.resize(16);
    return p;
  }
  set32(p, 36, adapter.max_width());
  set32(p, 46, adapter.max_y_origin());
  set32(p, 58, adapter.frame_height());
  p[74] = static_cast<std::uint8_t>(adapter.capacity());
  p[75] = static_cast<std::uint8_t>(adapter.frames_present());
  if (adapter.kind == AdapterKind::kAps) {
    p[4] = 0x0b;
    p[16] |= 0x10;
    p[17] = 0x35;
    set32(p, 62, adapter.frame_height());
  } else if (!adapter.strip()) {
    p[17] = adapter.kind == AdapterKind::kFeeder ? 0x32 : 0x22;
    set32(p, 62, 0);
    set16(p, 70, 0);
    set16(p, 72, 0);
  }
  return p;
}

Bytes abilities_page(const UnitModel& model, const AdapterState& adapter) {
  Bytes p = from_hex(model.page_d1);
  // Without a strip there is nothing to take thumbnails of.
  if (!adapter.holder() && !adapter.strip()) p[4] = 0x01;
  return p;
}

Bytes duties_page(const UnitModel& model, const AdapterState& adapter) {
  Bytes p = from_hex(model.page_e1);
  if (adapter.holder()) return p;
  switch (adapter.kind) {
    case AdapterKind::kMount:
      p[9] &= 0xbf;                                              // no perforations
      p[10] = static_cast<std::uint8_t>((p[10] & 0xfc) | 0x04);  // no frame table; factory WB
      p[22] = 0x02;
      p[26] &= 0xef;
      p[30] = 0x00;
      break;
    case AdapterKind::kAps:
      p[10] &= 0xfc;
      p[30] = 0x07;
      break;
    case AdapterKind::kFeeder:
      p[9] &= 0xbf;
      p[10] &= 0xfc;
      p[30] = 0x23;
      break;
    default:
      break;
  }
  return p;
}

Bytes frames_page(const AdapterState& adapter) {
  // One frame whose length a strip holder does not know, as seen with 6 x 9 film.
  Bytes body;
  put8(body, 1);
  put32(body, adapter.model->sensor_px > static_cast<int>(adapter.max_width()) ? 0x0206 : 0);
  put32(body, static_cast<std::uint32_t>(adapter.holder_top()));
  put32(body, adapter.max_width());
  put32(body, 0);
  return page(0xc8, body);
}

// Pages no program interprets, as recorded.
std::optional<Bytes> service_page(const UnitModel& model, std::uint8_t code) {
  const bool ls5000 = model.has_ccd_curves;
  switch (code) {
    case 0xe2:
      return from_hex("06E2001A 01 B4 0000003C 00000E10 00000000 00000001 00000000 00000000");
    case 0xe3:
      if (!ls5000) return std::nullopt;
      // Of an LS-9000 only the length of its curves is known: ten types stand in.
      return from_hex(std::string(model.sensor_lines > 2 ? "06E3002D 0701 0FA0 01 0A 13"
                                                         : "06E3002D 0701 0FA0 01 02 13") +
                      "  0000 0083 0106 0189 020C 028F 051F 0A3D 0CCC 1999 3333 4CCC "
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

int AdapterState::capacity() const {
  switch (kind) {
    case AdapterKind::kSa30:
    case AdapterKind::kAps:
      return 40;
    case AdapterKind::kSa21:
      return holder() ? 1 : 6;
    default:
      return 1;
  }
}

int AdapterState::frames_present() const {
  if (!film_present) return 0;
  return counted_frames > 0 ? counted_frames : capacity();
}

std::uint32_t AdapterState::frame_height() const {
  const int optical = model->optical_dpi;
  if (kind == AdapterKind::kAps) return static_cast<std::uint32_t>(4453 * optical / 4000);
  if (holder()) return get32(from_hex(model->page_c1), 58);
  return static_cast<std::uint32_t>(strip() ? model->frame_height_px : model->mount_height_px);
}

std::uint32_t AdapterState::max_width() const {
  if (holder()) return get32(from_hex(model->page_c1), 36);
  if (kind == AdapterKind::kAps) {
    return static_cast<std::uint32_t>(2916 * model->optical_dpi / 4000);
  }
  return static_cast<std::uint32_t>(model->sensor_px);
}

std::uint32_t AdapterState::x_end() const {
  return holder() ? static_cast<std::uint32_t>(model->sensor_px) : max_width();
}

std::uint32_t AdapterState::max_y_origin() const {
  if (holder()) return get32(from_hex(model->page_c1), 46);
  if (!strip()) return frame_height() - 1;
  if (!film_present) return 0;
  const auto frames = static_cast<std::uint32_t>(frames_present());
  if (kind == AdapterKind::kAps) return frames * frame_height() - 1;
  return (frames + 2) * frame_height();
}

int AdapterState::holder_top() const {
  return holder() && model->page_c1.starts_with("06C10057") ? 0x08bc : 0;
}

Bytes operation_groups(const UnitModel& model, const AdapterState& adapter) {
  // Units without page E1 focus and eject, too.
  if (model.page_e1.empty()) return from_hex("0300 0000 0100 0000 0300 0100 0000 0000");
  const Bytes p = duties_page(model, adapter);
  const auto end = p.end() - 3;  // what follows the groups
  return {end - 16, end};
}

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
      if (adapter.kind == AdapterKind::kNone) return std::nullopt;
      return name_page(code, adapter_name(adapter));
    case 0x10:
      if (adapter.kind != AdapterKind::kMount && !adapter.holder()) return std::nullopt;
      return name_page(code, adapter.holder() ? "Unknown" : "FH3");
    case 0x18:
      if (!adapter.holder()) return std::nullopt;
      return name_page(code, "FH-869G");
    case 0xc8:
      if (!adapter.holder()) return std::nullopt;
      return frames_page(adapter);
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
      if (model.page_d1.empty() || adapter.kind == AdapterKind::kNone) return std::nullopt;
      return abilities_page(model, adapter);
    case 0xe1:
      if (model.page_e1.empty() || adapter.kind == AdapterKind::kNone) return std::nullopt;
      return duties_page(model, adapter);
    default:
      return service_page(model, code);
  }
}

}  // namespace reseau::sim
