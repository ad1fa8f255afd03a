#include "drivers/pieusb/never.h"

#include "drivers/pieusb/commands.h"

namespace reseau::pieusb {
namespace {

const char* why_not_write(ByteView out) {
  if (out.size() < 4) return "a WRITE without its head";
  const auto sub_command = load_le(out, 0, 2);
  const auto length = load_le(out, 2, 2);
  // What asks for a reply has two bytes that are not counted.
  const std::size_t counted = sub_command == 0x95 ? 0 : out.size() - 4;
  if (length != counted) return "a WRITE whose length field does not fit its data";
  switch (sub_command) {
    case 0x12: {
      if (out.size() != 14) return "a scan frame of the wrong size";
      const bool in_order =
          load_le(out, 6, 2) <= load_le(out, 10, 2) && load_le(out, 8, 2) <= load_le(out, 12, 2);
      return in_order ? nullptr : "a scan frame whose corners are the wrong way round";
    }
    case 0x13:
    case 0x14:
      return out.size() == 8 && load_le(out, 6, 2) == 100
                 ? nullptr
                 : "percentages other than 100 have never been seen on the wire";
    case 0x17:
      return out.size() == 6 ? nullptr : "a sub-command 17 of the wrong size";
    case 0x95:
      return out.size() == 6 ? nullptr : "a sub-command 95 of the wrong size";
    default:
      return "a WRITE sub-command that nobody uses";
  }
}

const char* why_not_mode(ByteView out) {
  if (out.size() != 16) return "MODE SELECT has 16 bytes";
  const int passes = u8_at(out, 4);
  if (passes != 0x80 && passes != 0x90) return "modes of a single filter do not work";
  if (u8_at(out, 6) != 0x04) return "only lines with tags are read";
  if ((u8_at(out, 14) & 1) != 0) return "the carriage must not stay at the far end";
  return nullptr;
}

const char* why_not_slide(ByteView out) {
  if (out.size() != 4) return "SLIDE has 4 bytes";
  switch (u8_at(out, 0)) {
    case 0x04:
    case 0x05:
    case 0x10:
      return u8_at(out, 1) == 1 && u8_at(out, 2) == 0 && u8_at(out, 3) <= 1
                 ? nullptr
                 : "a SLIDE parameter that this program does not use";
    default:
      return "a SLIDE action that this program does not use";
  }
}

const char* why_not_read(const Cdb& cdb, std::size_t in_bytes) {
  // Replies to a prepared question are read by their bytes.
  const int n = length_of(cdb);
  if (n < 1) return "a READ of nothing";
  if (static_cast<std::size_t>(n) == in_bytes) return nullptr;
  if (n > kMaxReadLines) return "a READ of more lines than the vendor's program asks for";
  if (n == kCursedLines) return "a READ of 64 lines has made a unit fall silent";
  if (in_bytes > kMaxReadBytes) return "a READ of more bytes than the vendor's program asks for";
  if (in_bytes % static_cast<std::size_t>(n) != 0) return "a READ that is not whole lines";
  return nullptr;
}

}  // namespace

const char* why_never(const Cdb& cdb, ByteView out, std::size_t in_bytes) {
  if (cdb.bytes().size() != 6) return "commands of this family have 6 bytes";
  if (u8_at(cdb.bytes(), 1) != 0 || u8_at(cdb.bytes(), 2) != 0 || u8_at(cdb.bytes(), 5) != 0) {
    return "a command with bytes in fields that are always 0";
  }
  const Op op = op_of(cdb);
  const auto length = static_cast<std::size_t>(length_of(cdb));
  switch (op) {
    case Op::kTestUnitReady:
      return length == 0 && out.empty() && in_bytes == 0 ? nullptr : "TEST UNIT READY has no data";
    case Op::kScan:
      if (length == 0) return "SCAN stop leaves a unit without answers; read to the end instead";
      return length == 1 && out.empty() && in_bytes == 0 ? nullptr : "SCAN starts with 1";
    case Op::kSetScanHead:
      return "SET SCAN HEAD has no feedback and strips gears";
    case Op::kModeSense:
      return "the vendor's program never sends MODE SENSE";
    case Op::kVendorE7:
      return "nobody knows what E7 does";
    case Op::kRead:
      return out.empty() ? why_not_read(cdb, in_bytes) : "READ sends no data";
    case Op::kRequestSense:
    case Op::kGetParameters:
    case Op::kInquiry:
    case Op::kCopy:
    case Op::kReadGain:
    case Op::kReadState:
      return out.empty() && length == in_bytes && length > 0
                 ? nullptr
                 : "a length field that does not fit the data";
    case Op::kWrite:
    case Op::kModeSelect:
    case Op::kSlide:
    case Op::kWriteGain:
      break;
    default:
      return "a command that nobody uses";
  }
  if (length != out.size() || in_bytes != 0) return "a length field that does not fit the data";
  if (op == Op::kWrite) return why_not_write(out);
  if (op == Op::kModeSelect) return why_not_mode(out);
  if (op == Op::kSlide) return why_not_slide(out);
  return out.size() == 29 ? nullptr : "WRITE GAIN/OFFSET has 29 bytes";
}

}  // namespace reseau::pieusb
