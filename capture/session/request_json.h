// What a scan was asked to do, as the comment at the head of a recording, so that a replay asks for
// the same.
#pragma once

#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "drivers/scan_plan.h"

namespace reseau {

struct RecordedRequest {
  ScanRequest request;
  std::string device_name;     // as in `-d`
  std::string started_at_utc;  // ISO 8601
};

[[nodiscard]] nlohmann::ordered_json request_to_json(const ScanRequest& request);

// {"schema": "reseau-request/1", "device": …, "started_at_utc": …, "request": {…}}, one line.
[[nodiscard]] std::string recorded_request_to_json(const RecordedRequest& recorded);

// Nothing when the text is no such comment (a recording by another program). Throws InputError when
// it says it is one and cannot be understood; `source` names the recording.
[[nodiscard]] std::optional<RecordedRequest> recorded_request_from_json(const std::string& text,
                                                                        const std::string& source);

}  // namespace reseau
