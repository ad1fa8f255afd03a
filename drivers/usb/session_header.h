#pragma once

#include <string>

namespace reseau {

// What a recording says of itself, kept as the comment of its section header.
struct SessionHeader {
  std::string device_name;     // "sim:ls5000"
  std::string started_at_utc;  // ISO 8601
  std::string comment;         // the caller's, e.g. the request as JSON
  bool operator==(const SessionHeader&) const = default;
};

[[nodiscard]] std::string encode_session_header(const SessionHeader& header);
// A comment that another program wrote is taken as the caller's.
[[nodiscard]] SessionHeader decode_session_header(const std::string& text);

}  // namespace reseau
