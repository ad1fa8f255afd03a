#include "drivers/scsi/cdb.h"

namespace reseau {
namespace {

// LS-5000 interface specification, command list; E0, E1 and C0 are vendor commands there.
const char* name_of(std::uint8_t opcode) {
  switch (opcode) {
    case 0x00:
      return "TEST UNIT READY";
    case 0x03:
      return "REQUEST SENSE";
    case 0x12:
      return "INQUIRY";
    case 0x15:
      return "MODE SELECT";
    case 0x16:
      return "RESERVE UNIT";
    case 0x17:
      return "RELEASE UNIT";
    case 0x1A:
      return "MODE SENSE";
    case 0x1B:
      return "SCAN";
    case 0x1C:
      return "RECEIVE DIAGNOSTIC RESULTS";
    case 0x1D:
      return "SEND DIAGNOSTIC";
    case 0x24:
      return "SET WINDOW";
    case 0x25:
      return "GET WINDOW";
    case 0x28:
      return "READ";
    case 0x2A:
      return "SEND";
    case 0xC0:
      return "ABORT";
    case 0xC1:
      return "EXECUTE";
    case 0xE0:
      return "SET PARAMETER";
    case 0xE1:
      return "GET PARAMETER";
    default:
      return "unknown command";
  }
}

}  // namespace

std::string Cdb::describe() const {
  std::string text = name_of(opcode());
  if (opcode() == 0x28 && bytes_[2] == std::byte{0}) text += " image";
  if (size_ == 10) text += ", " + std::to_string(load_be(bytes(), 6, 3)) + " bytes";
  return text + " [" + hex_of(bytes()) + "]";
}

}  // namespace reseau
