// What is never sent to a unit, because it has broken, hung or lost one, or because nothing is
// known of it. One list, asked before every single command (PieBridge), whoever built the command.
// Reasons and sources: drivers/pieusb/README.md, *Never*.
#pragma once

#include <cstddef>

#include "drivers/bytes.h"
#include "drivers/scsi/cdb.h"

namespace reseau::pieusb {

// READs of so many lines have made a unit send nothing.
inline constexpr int kCursedLines = 64;
inline constexpr int kMaxReadLines = 216;  // what the vendor's program asks for at most
inline constexpr std::size_t kMaxReadBytes = 512 * 1024;  // likewise
// Data stops after so much of one announcement.
inline constexpr std::size_t kMaxAnnouncedBytes = 32 * 1024;
inline constexpr std::size_t kMaxBulkBytes = 16 * 1024;

// nullptr for a command that may be sent with this data; otherwise why it never is.
// in_bytes: what the host would read. Pure.
[[nodiscard]] const char* why_never(const Cdb& cdb, ByteView out, std::size_t in_bytes);

}  // namespace reseau::pieusb
