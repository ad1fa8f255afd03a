// What can be done with a recording besides replaying it: read it, check it, make it fit to be
// given away. Recordings are pcapng or pcap files with USB traffic (drivers/README.md).
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace reseau {

// One command, or one control transfer, with all that belonged to it.
struct ShownExchange {
  int number = 0;                  // from 1
  std::uint64_t first_packet = 0;  // as Wireshark counts
  double start_s = 0;              // since the first one
  double duration_ms = 0;
  std::string phase;        // "focus"; as the recording names it
  std::string command;      // "SET WINDOW, 58 bytes [24 …]"
  std::string command_hex;  // "24 00 …"
  std::uint64_t out_bytes = 0, in_bytes = 0;
  std::string status_hex;  // 8 bytes, or empty
  std::string outcome;     // "good", or a sentence
  bool good = false;
  std::string text;  // all of it, some lines
};

struct ShownSession {
  std::string device;      // "04b0:4002", from the descriptors
  std::string serial;      // may be empty
  std::string name;        // as it was opened, when the recording is ours
  std::string started_at;  // the same
  int n_exchanges = 0;
};

// Calls `each` for every exchange, in order. Throws InputError or std::system_error.
ShownSession show_session(const std::filesystem::path& file,
                          const std::function<void(const ShownExchange&)>& each);

// What is wrong with a recording as a fixture or as evidence; nothing when it is whole.
struct SessionCheck {
  ShownSession session;
  int n_failed_transfers = 0;  // recorded failures: not a fault of the recording
  int n_not_ready = 0;         // busy, warming up, without film: what a poll is there to hear
  int n_refused = 0;           // commands that the unit does not know, cannot do, or gave up
  std::vector<std::string> problems;  // sentences
};
// Throws InputError or std::system_error for what is no recording at all.
[[nodiscard]] SessionCheck check_session(const std::filesystem::path& file);

struct RewriteOptions {
  // Exchanges of these numbers, and what described the unit before its first command.
  int first_exchange = 1;
  int last_exchange = 1 << 30;
  std::string phase;  // not empty: only exchanges of this phase
  // The serial, and whatever else must not leave the house; each character becomes an X.
  bool blank_serial = false;
  std::vector<std::string> also_blank;
};

struct RewriteResult {
  int n_exchanges = 0;
  int n_packets = 0;
  int n_packets_left_out = 0;  // of other devices, or outside the part
  int n_blanked = 0;           // places
};

// Writes a recording anew as a session of ours: only the scanner of the capture, only the part that
// is asked for. Takes pcapng and pcap of usbmon and USBPcap, and the command lists (*.jsonl) of
// another program. Never overwrites. Throws InputError or std::system_error.
RewriteResult rewrite_session(const std::filesystem::path& from, const std::filesystem::path& to,
                              const RewriteOptions& options);

}  // namespace reseau
