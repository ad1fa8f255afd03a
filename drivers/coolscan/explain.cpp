#include "drivers/coolscan/explain.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <optional>
#include <variant>

#include "drivers/coolscan/commands.h"
#include "drivers/coolscan/pages.h"
#include "drivers/coolscan/records.h"
#include "drivers/coolscan/window.h"

namespace reseau::coolscan {
namespace {

bool has_cdb_size(ByteView cdb) { return cdb.size() == 6 || cdb.size() == 10; }

template <typename... Values>
std::string formatted(const char* form, Values... values) {
  std::array<char, 200> text{};
  std::snprintf(text.data(), text.size(), form, values...);
  return text.data();
}

const char* colour_name(int colour) {
  switch (colour) {
    case 0:
      return "default";
    case 1:
      return "red";
    case 2:
      return "green";
    case 3:
      return "blue";
    case 4:
      return "grey";
    case 9:
      return "infrared";
    default:
      return "unknown colour";
  }
}

// LS-5000 interface specification, READ and SEND.
const char* data_name(int type) {
  switch (type) {
    case 0x00:
      return "image";
    case 0x03:
      return "look-up table";
    case 0x81:
      return "maximum level";
    case 0x84:
      return "shading";
    case 0x85:
      return "dark data";
    case 0x87:
      return "cooperation record";
    case 0x88:
      return "frame rectangles";
    case 0x8A:
      return "analog gain";
    case 0x8C:
      return "white-balance exposure";
    case 0x8D:
      return "setup information";
    case 0x8E:
      return "perforation table";
    case 0x8F:
      return "frame table";
    case 0x90:
      return "factory white balance";
    case 0x91:
      return "CCD curves";
    case 0x92:
      return "driver version";
    case 0x93:
      return "leak volume";
    case 0xE0:
      return "scratch memory";
    default:
      return "unknown data";
  }
}

// LS-5000 interface specification, SET PARAMETER.
const char* operation_name(int operation) {
  switch (operation) {
    case 0x80:
      return "initialise";
    case 0x81:
      return "return to origin";
    case 0x91:
      return "automatic focus at load";
    case 0x92:
      return "automatic calibration";
    case 0xA0:
      return "autofocus at a point";
    case 0xB0:
      return "measure shading";
    case 0xB1:
      return "measure dark";
    case 0xB3:
      return "write device data";
    case 0xB4:
      return "unload timer";
    case 0xC0:
      return "move stage";
    case 0xC1:
      return "move focus";
    case 0xD0:
      return "unload";
    case 0xD1:
      return "load";
    case 0xD2:
      return "position film";
    case 0xD5:
      return "feeder motor";
    case 0xD6:
      return "adapter lock";
    default:
      return "unknown operation";
  }
}

void explain_window(ByteView data, std::vector<std::string>& lines) {
  const std::optional<Window> w = decode_window(data);
  if (!w) return;
  lines.push_back(formatted("window %s: %d dpi, x %d y %d, %d x %d, %d bits, exposure %.2f us",
                            colour_name(static_cast<int>(w->colour)), w->resolution_dpi, w->x_px,
                            w->y_px, w->width_px, w->height_px, w->bits,
                            w->exposure_10ns / k10nsPerUs));
  lines.push_back(formatted("kind %02X, mode %02X, interleaving %02X, readings %d%s%s",
                            unsigned{static_cast<std::uint8_t>(w->kind)}, unsigned{w->mode},
                            unsigned{static_cast<std::uint8_t>(w->interleaving)}, w->readings,
                            w->averaging ? ", averaging" : "",
                            w->positive ? ", positive" : ", negative"));
}

void explain_record(ByteView data, std::vector<std::string>& lines) {
  const std::optional<CooperationRecord> record = parse_cooperation(data);
  if (!record) return;
  if (const auto* line = std::get_if<LineRecord>(&*record)) {
    const char* const duty = line->type == 1   ? "build the thumbnails"
                             : line->type == 2 ? "average the readings"
                                               : "put the sensor lines in place";
    lines.push_back(formatted("the host shall %s: %d lines, %d bits, %d readings, gap %d", duty,
                              line->n_lines, line->bits, line->readings, line->registration_gap));
  } else if (const auto* padding = std::get_if<PaddingRecord>(&*record)) {
    lines.push_back(formatted(
        "the host shall remove padding: colour %d and %d, line %d and %d bytes, %d and "
        "%d lines",
        padding->colour_before_bytes, padding->colour_after_bytes, padding->line_before_bytes,
        padding->line_after_bytes, padding->top_lines, padding->bottom_lines));
  } else {
    lines.emplace_back("the host shall correct with the CCD curves");
  }
}

void explain_read(ByteView cdb, ByteView in, std::vector<std::string>& lines) {
  const auto type = static_cast<DataType>(u8_at(cdb, 2));
  lines.push_back(
      formatted("data: %s, colour %s", data_name(u8_at(cdb, 2)), colour_name(u8_at(cdb, 4))));
  constexpr std::size_t kExposureBytes = kDataHeadBytes + 4;
  if (type == DataType::kCooperation) explain_record(in, lines);
  if (type == DataType::kWhiteBalanceExposure && in.size() >= kExposureBytes) {
    lines.push_back(formatted("exposure %.2f us",
                              static_cast<double>(load_be(in, kDataHeadBytes, 4)) / k10nsPerUs));
  }
}

std::string text_in(ByteView bytes) {
  std::string text;
  for (const std::byte b : bytes) {
    const auto c = std::to_integer<unsigned char>(b);
    text += c >= 0x20 && c < 0x7F ? static_cast<char>(c) : '.';
  }
  return text;
}

void explain_inquiry(ByteView cdb, ByteView in, std::vector<std::string>& lines) {
  if (u8_at(cdb, 1) != 0) {
    lines.push_back(formatted("page %02X", unsigned{u8_at(cdb, 2)}));
    return;
  }
  constexpr std::size_t kVendor = 8;
  if (in.size() < kInquiryBytes) return;
  lines.push_back("\"" + text_in(in.subspan(kVendor, kInquiryBytes - kVendor)) + "\"");
}

void explain_parameters(ByteView cdb, ByteView block, std::vector<std::string>& lines) {
  lines.push_back(
      formatted("operation %02X, %s", unsigned{u8_at(cdb, 2)}, operation_name(u8_at(cdb, 2))));
  if (block.size() < kParameterBytes) return;
  const Parameters p = decode_parameters(block);
  lines.push_back(formatted("values %u and %u", unsigned{p.first}, unsigned{p.second}));
}

}  // namespace

std::string name_of_command(ByteView cdb) {
  return has_cdb_size(cdb) ? Cdb(cdb).describe() : hex_of(cdb);
}

std::vector<std::string> explain(ByteView cdb, ByteView out, ByteView in) {
  std::vector<std::string> lines;
  if (!has_cdb_size(cdb)) return lines;
  const int opcode = u8_at(cdb, 0);
  const bool long_form = cdb.size() == 10;
  if (opcode == 0x12 && !long_form) explain_inquiry(cdb, in, lines);
  if (opcode == 0x1B && !out.empty()) {
    std::string colours = "colours";
    for (const std::byte id : out)
      colours.append(" ").append(colour_name(std::to_integer<int>(id)));
    lines.push_back(std::move(colours));
  }
  if (!long_form) return lines;
  if (opcode == 0x24) explain_window(out, lines);
  if (opcode == 0x25) explain_window(in, lines);
  if (opcode == 0x28) explain_read(cdb, in, lines);
  if (opcode == 0x2A) {
    lines.push_back(
        formatted("data: %s, colour %s", data_name(u8_at(cdb, 2)), colour_name(u8_at(cdb, 4))));
  }
  if (opcode == 0xE0) explain_parameters(cdb, out, lines);
  if (opcode == 0xE1) explain_parameters(cdb, in, lines);
  return lines;
}

std::string source_of(ByteView cdb) {
  if (!has_cdb_size(cdb)) return "Nikon's USB wrapper: drivers/scsi/nikon_usb_scsi";
  const std::string place = "LS-5000 interface specification, ";
  switch (u8_at(cdb, 0)) {
    case 0x12:
      return place + "INQUIRY; parsed by drivers/coolscan/pages";
    case 0x15:
      return place + "MODE SELECT; sent by drivers/coolscan/unit";
    case 0x1B:
      return place + "SCAN; sequence in drivers/coolscan/unit";
    case 0x24:
    case 0x25:
      return place + "SET WINDOW; drivers/coolscan/window, values from drivers/coolscan/plan";
    case 0x28:
      return place + "READ; sizes from drivers/coolscan/record_layout and records";
    case 0x2A:
      return place + "SEND; drivers/coolscan/frames and commands";
    case 0xC0:
      return place + "ABORT; sent by drivers/coolscan/unit";
    case 0xC1:
    case 0xE0:
    case 0xE1:
      return place + "SET PARAMETER; drivers/coolscan/commands";
    default:
      return place + "command list; drivers/coolscan/commands";
  }
}

}  // namespace reseau::coolscan
