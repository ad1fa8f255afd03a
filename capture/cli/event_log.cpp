#include "capture/cli/event_log.h"

#include <chrono>
#include <utility>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace reseau::cli {

std::string utc_now(bool milliseconds) {
  const auto now = std::chrono::system_clock::now();
  const auto seconds = std::chrono::floor<std::chrono::seconds>(now);
  const std::string head = fmt::format("{:%Y-%m-%dT%H:%M:%S}", fmt::gmtime(seconds));
  if (!milliseconds) return head + "Z";
  return fmt::format("{}.{:03}Z", head,
                     std::chrono::duration_cast<std::chrono::milliseconds>(now - seconds).count());
}

EventLog::EventLog(std::ostream& out, const std::string& verb) : out_(out) {
  const nlohmann::ordered_json first = {{"schema", "reseau-events/1"},
                                        {"program", "reseau"},
                                        {"version", RESEAU_VERSION},
                                        {"verb", verb},
                                        {"t", utc_now(true)}};
  out_ << first.dump() << '\n' << std::flush;
}

void EventLog::write(const std::string& event, nlohmann::ordered_json fields) {
  nlohmann::ordered_json line = {{"t", utc_now(true)}, {"event", event}};
  line.update(fields);
  // Names of files need not be UTF-8; a replacement character is better than no event.
  const std::string text = line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  const std::lock_guard lock(mutex_);
  out_ << text << '\n' << std::flush;
}

}  // namespace reseau::cli
