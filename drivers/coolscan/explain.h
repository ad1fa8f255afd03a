// What a command and its data mean, for people who read a recording. Pure, reentrant.
#pragma once

#include <string>
#include <vector>

#include "drivers/bytes.h"

namespace reseau::coolscan {

// "SET WINDOW, 58 bytes [24 …]"; bytes of another length than a CDB's are shown as they are.
[[nodiscard]] std::string name_of_command(ByteView cdb);

// A line for each thing that the data says, e.g. a window's resolution, area and exposure. Empty
// for commands without data, for image data, and for what is not known. Never throws for what a
// recording may hold.
[[nodiscard]] std::vector<std::string> explain(ByteView cdb, ByteView out, ByteView in);

// Where the form of a command is described: what a person compares when a replay differs.
[[nodiscard]] std::string source_of(ByteView cdb);

}  // namespace reseau::coolscan
