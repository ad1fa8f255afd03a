// A capture written anew as a session of ours: only the scanner, only a part, without serials.
#pragma once

#include <filesystem>

#include "drivers/sessions.h"

namespace reseau {

// Reads pcapng or pcap (link types 189, 220, 249) and writes pcapng of link type 220. Never
// overwrites. Throws InputError or std::system_error.
RewriteResult rewrite_recording(const std::filesystem::path& from, const std::filesystem::path& to,
                                const RewriteOptions& options);

// From commands as a program for LS-5000 units keeps them, one JSON object a line with cdb,
// data_out, expected_phase, expected_data_in, expected_status, to a session. Image bytes that the
// file does not hold are left out; the packets say how many there were. Returns how many commands.
int import_command_lines(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace reseau
