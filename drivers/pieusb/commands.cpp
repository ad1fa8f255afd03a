#include "drivers/pieusb/commands.h"

#include "core/base/check.h"

namespace reseau::pieusb {
namespace {

constexpr int kFrameIndex = 0x80;
constexpr int kAlways100 = 100;

const char* name_of(Op op) {
  switch (op) {
    case Op::kTestUnitReady:
      return "TEST UNIT READY";
    case Op::kRequestSense:
      return "REQUEST SENSE";
    case Op::kRead:
      return "READ";
    case Op::kWrite:
      return "WRITE";
    case Op::kGetParameters:
      return "GET PARAMETERS";
    case Op::kInquiry:
      return "INQUIRY";
    case Op::kModeSelect:
      return "MODE SELECT";
    case Op::kCopy:
      return "COPY of the sensor mask";
    case Op::kModeSense:
      return "MODE SENSE";
    case Op::kScan:
      return "SCAN";
    case Op::kSlide:
      return "SLIDE";
    case Op::kSetScanHead:
      return "SET SCAN HEAD";
    case Op::kReadGain:
      return "READ GAIN/OFFSET";
    case Op::kWriteGain:
      return "WRITE GAIN/OFFSET";
    case Op::kReadState:
      return "READ STATE";
    case Op::kVendorE7:
      return "vendor command";
  }
  return "unknown command";
}

void append_words(Bytes& bytes, std::initializer_list<int> words) {
  for (const int word : words) append_le(bytes, 2, static_cast<std::uint64_t>(word));
}

}  // namespace

Cdb command_of(Op op, int length) {
  CHECK(length >= 0 && length <= 0xFFFF);
  return {static_cast<int>(op), 0, 0, length >> 8, length & 0xFF, 0};
}

int length_of(const Cdb& cdb) { return static_cast<int>(load_be(cdb.bytes(), 3, 2)); }

std::string describe(const Cdb& cdb) {
  std::string text = name_of(op_of(cdb));
  if (op_of(cdb) == Op::kScan) {
    text += length_of(cdb) == 0 ? ", stop" : ", start";
  } else if (length_of(cdb) > 0) {
    text += ", " + std::to_string(length_of(cdb));
    text += op_of(cdb) == Op::kRead ? " lines" : " bytes";
  }
  return text + " [" + hex_of(cdb.bytes()) + "]";
}

Bytes scan_frame_data(const ScanFrame& frame) {
  Bytes data;
  append_words(data, {0x12, 10, kFrameIndex, frame.x0, frame.y0, frame.x1, frame.y1});
  return data;
}

Bytes filter_percentage_data(int sub_command, int filter) {
  Bytes data;
  append_words(data, {sub_command, 4, filter, kAlways100});
  return data;
}

Bytes prepare_calibration_info_data() {
  // The highest bit of the sub-code's byte asks for a reply that the next READ takes. Two bytes
  // more than the length counts, as SANE's pieusb backend sends it to units that answer.
  Bytes data;
  append_words(data, {0x95, 0, 0});
  return data;
}

Bytes confirm_frame_data() {
  Bytes data;
  append_words(data, {0x17, 2, 1});
  return data;
}

Bytes mode_data(const Mode& mode) {
  CHECK(mode.depth_bits == 8 || mode.depth_bits == 16);
  Bytes data = bytes_of({0, 0x0F});
  append_le(data, 2, static_cast<std::uint64_t>(mode.dpi));
  append_le(data, 1, mode.infrared ? 0x90 : 0x80);
  append_le(data, 1, mode.depth_bits == 16 ? 0x20 : 0x04);
  append_le(data, 1, 0x04);  // lines with a tag of their colour
  append_le(data, 1, 0);
  append_le(data, 1, 0x01);  // little-endian samples
  append_le(data, 2, mode.quality);
  append_le(data, 1, 0);
  append_le(data, 1, 0);     // halftone pattern
  append_le(data, 1, 0x80);  // line threshold; without meaning at these depths
  // Bit 0 clear: the carriage goes home, so that passes come top-down. The high digit is
  // UNVERIFIED(unexplained; SANE's backend sends the same).
  append_le(data, 1, 0x10);
  append_le(data, 1, 0);
  return data;
}

Bytes gain_data(const GainOffset& gain) {
  constexpr std::size_t kBytes = 29;
  Bytes data(kBytes, std::byte{0});
  const auto put16 = [&](std::size_t at, std::uint16_t value) {
    data[at] = std::byte(value & 0xFF);
    data[at + 1] = std::byte(value >> 8);
  };
  for (std::size_t c = 0; c < 3; ++c) {
    put16(2 * c, gain.exposure[c]);
    data[6 + c] = std::byte{gain.offset[c]};
    data[12 + c] = std::byte{gain.gain[c]};
  }
  data[15] = std::byte{gain.light};
  data[16] = std::byte(gain.infrared ? 1 : 0);
  put16(18, gain.exposure[3]);
  data[20] = std::byte{gain.offset[3]};
  data[22] = std::byte{gain.gain[3]};
  data[27] = std::byte(gain.infrared ? 1 : 0);
  return data;
}

Bytes slide_data(SlideAction action) {
  switch (action) {
    case SlideAction::kNext:
      return bytes_of({0x04, 0x01, 0, 0x01});
    case SlideAction::kPrevious:
      return bytes_of({0x05, 0x01, 0, 0x01});
    case SlideAction::kInitialise:
      return bytes_of({0x10, 0x01, 0, 0});
  }
  return {};
}

}  // namespace reseau::pieusb
