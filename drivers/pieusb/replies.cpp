#include "drivers/pieusb/replies.h"

#include <algorithm>

#include "core/base/error.h"

namespace reseau::pieusb {
namespace {

constexpr int kMaxDpi = 20000, kMaxSidePx = 65535;

[[noreturn]] void broken(const char* what, ByteView bytes) {
  throw DeviceError(DeviceError::Kind::kProtocol,
                    std::string("The scanner's answer makes no sense (") + what +
                        "). Scan again; if it happens again, switch the scanner off and on.",
                    hex_of(bytes, 200));
}

void require(bool good, const char* what, ByteView bytes) {
  if (!good) broken(what, bytes);
}

int word(ByteView bytes, std::size_t at) { return static_cast<int>(load_le(bytes, at, 2)); }

// Printable characters without the blanks around them.
std::string text_of(ByteView bytes) {
  std::string text;
  for (const std::byte b : bytes) {
    const auto c = static_cast<char>(b);
    text += c >= ' ' && c <= '~' ? c : ' ';
  }
  const std::size_t end = text.find_last_not_of(' ');
  const std::size_t begin = text.find_first_not_of(' ');
  return end == std::string::npos ? std::string() : text.substr(begin, end - begin + 1);
}

}  // namespace

std::size_t inquiry_length(ByteView head) {
  require(head.size() >= 5, "the head of INQUIRY is short", head);
  return std::size_t{u8_at(head, 4)} + 4;
}

Inquiry parse_inquiry(ByteView b) {
  constexpr std::size_t kNeeded = 118;
  require(b.size() >= kNeeded, "INQUIRY is short", b);
  Inquiry inquiry;
  inquiry.vendor = text_of(b.subspan(8, 8));
  inquiry.product = text_of(b.subspan(16, 16));
  inquiry.revision = text_of(b.subspan(32, 4));
  inquiry.firmware = text_of(b.subspan(96, 4));
  inquiry.max_dpi = word(b, 36);
  inquiry.area = {word(b, 108), word(b, 110), word(b, 112), word(b, 114)};
  inquiry.max_width_px = word(b, 40);
  inquiry.max_height_px = word(b, 42);
  const int filters = u8_at(b, 44);
  inquiry.infrared = (filters & 0x10) != 0;
  inquiry.one_pass = (filters & 0x80) != 0;
  if ((u8_at(b, 45) & 0x04) != 0) inquiry.depths_bits.push_back(8);
  if ((u8_at(b, 45) & 0x20) != 0) inquiry.depths_bits.push_back(16);
  inquiry.index_format = (u8_at(b, 46) & 0x04) != 0;
  inquiry.confirms_frame = (u8_at(b, 50) & 0x04) != 0;
  inquiry.max_exposure = word(b, 104);
  inquiry.min_exposure = word(b, 106);
  inquiry.model_number = word(b, 116);
  require(inquiry.max_dpi >= 100 && inquiry.max_dpi <= kMaxDpi, "the resolution", b);
  const int area_width_px = inquiry.area.x1 - inquiry.area.x0;
  const int area_height_px = inquiry.area.y1 - inquiry.area.y0;
  if (area_width_px > 0) inquiry.max_width_px = std::min(inquiry.max_width_px, area_width_px);
  if (area_height_px > 0) inquiry.max_height_px = std::min(inquiry.max_height_px, area_height_px);
  require(inquiry.max_width_px > 0 && inquiry.max_height_px > 0, "the scan area", b);
  require(inquiry.area.x0 + inquiry.max_width_px <= kMaxSidePx &&
              inquiry.area.y0 + inquiry.max_height_px <= kMaxSidePx,
          "the scan area", b);
  return inquiry;
}

State parse_state(ByteView b, bool reports_film) {
  require(b.size() >= 12, "READ STATE is short", b);
  State state;
  state.frame = u8_at(b, 2);
  state.warming_up = u8_at(b, 5) != 0;
  state.no_film = reports_film && u8_at(b, 8) != 0;
  return state;
}

GainReference parse_gain(ByteView b) {
  require(b.size() >= 103, "READ GAIN/OFFSET is short", b);
  GainReference gain;
  for (std::size_t c = 0; c < 3; ++c) {
    gain.exposure[c] = static_cast<std::uint16_t>(word(b, 60 + 2 * c));
    gain.offset[c] = u8_at(b, 66 + c);
    gain.gain[c] = u8_at(b, 72 + c);
  }
  gain.exposure[3] = static_cast<std::uint16_t>(word(b, 98));
  gain.offset[3] = u8_at(b, 100);
  gain.gain[3] = u8_at(b, 102);
  for (std::uint16_t& exposure : gain.exposure) {
    require(exposure != 0, "the reference exposure is 0", b);
  }
  return gain;
}

CalibrationInfo parse_calibration_info(ByteView b) {
  constexpr std::size_t kHead = 8;
  require(b.size() >= kHead && u8_at(b, 0) == 0x95, "the calibration info", b);
  const std::size_t n_entries = u8_at(b, 4), entry_bytes = u8_at(b, 5);
  require(n_entries >= 1 && entry_bytes >= 6 && kHead + n_entries * entry_bytes <= b.size(),
          "the calibration info", b);
  CalibrationInfo info;
  for (std::size_t i = 0; i < n_entries; ++i) {
    const std::size_t at = kHead + i * entry_bytes;
    info.n_lines += u8_at(b, at + 3);
    info.width_px = std::max(info.width_px, word(b, at + 4));
  }
  require(info.n_lines > 0 && info.width_px > 0, "the calibration info", b);
  return info;
}

ScanParameters parse_parameters(ByteView b) {
  require(b.size() >= 6, "GET PARAMETERS is short", b);
  const ScanParameters parameters{word(b, 0), word(b, 2), word(b, 4)};
  require(parameters.width_px > 0 && parameters.n_lines > 0, "an empty scan", b);
  require(parameters.line_bytes == parameters.width_px ||
              parameters.line_bytes == 2 * parameters.width_px,
          "bytes per line", b);
  return parameters;
}

Sense parse_sense(ByteView b) {
  require(b.size() >= kSenseBytes, "REQUEST SENSE is short", b);
  Sense sense;
  sense.key = u8_at(b, 2) & 0x0F;
  sense.asc = u8_at(b, 12);
  sense.ascq = u8_at(b, 13);
  return sense;
}

std::vector<int> parse_mask(ByteView b) {
  std::vector<int> used;
  for (std::size_t i = 0; i < b.size(); ++i) {
    if (b[i] == std::byte{0}) used.push_back(static_cast<int>(i));
  }
  return used;
}

}  // namespace reseau::pieusb
