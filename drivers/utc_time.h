#pragma once

#include <chrono>
#include <ctime>
#include <string>

namespace reseau {

// The time of the day for files: "2026-11-22T10:15:00Z".
[[nodiscard]] inline std::string utc_now() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

}  // namespace reseau
