// `--json`: newline-delimited JSON on stdout, one object per line, the first naming the schema.
#pragma once

#include <mutex>
#include <ostream>
#include <string>

#include <nlohmann/json_fwd.hpp>

namespace reseau::cli {

// "2026-11-22T10:15:00.123Z"
[[nodiscard]] std::string utc_now(bool milliseconds);

// Thread-safe. A broken stdout is remembered, never an exception: nobody loses a scan because the
// reader of its events went away.
class EventLog {
 public:
  // Writes the schema line at once.
  EventLog(std::ostream& out, const std::string& verb);

  // Adds `t` and `event` to fields (an object) and writes the line.
  void write(const std::string& event, nlohmann::ordered_json fields);

 private:
  std::mutex mutex_;
  std::ostream& out_;
};

}  // namespace reseau::cli
