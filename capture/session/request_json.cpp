#include "capture/session/request_json.h"

#include <array>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/error.h"

namespace reseau {

namespace {

using nlohmann::json;
using nlohmann::ordered_json;

constexpr std::array kExposureNames{"red", "green", "blue", "infrared"};
constexpr std::array kSensorLineNames{"auto", "one", "all"};
constexpr const char* kSchema = "reseau-request/1";

template <typename T>
void put_optional(ordered_json& object, const char* key, const std::optional<T>& value) {
  if (value) object[key] = *value;
}

template <typename T>
std::optional<T> get_optional(const json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || found->is_null()) return std::nullopt;
  return found->get<T>();
}

FocusRequest focus_from_json(const json& object) {
  FocusRequest focus;
  const auto mode = object.value("mode", std::string("auto"));
  if (mode == "keep") {
    focus.mode = FocusRequest::Mode::kKeep;
  } else if (mode == "position") {
    focus.mode = FocusRequest::Mode::kPosition;
  } else if (mode != "auto") {
    throw InputError("unknown focus mode " + mode);
  }
  focus.position = object.value("position", 0);
  focus.x_mm = get_optional<double>(object, "x_mm");
  focus.y_mm = get_optional<double>(object, "y_mm");
  return focus;
}

ExposureRequest exposure_from_json(const json& object) {
  ExposureRequest exposure;
  const auto mode = object.value("mode", std::string("meter"));
  if (mode == "fixed") {
    exposure.mode = ExposureRequest::Mode::kFixed;
  } else if (mode != "meter") {
    throw InputError("unknown exposure mode " + mode);
  }
  exposure.factor = object.value("factor", 1.0);
  exposure.lock = object.value("lock", true);
  for (std::size_t i = 0; i < kExposureNames.size(); ++i) {
    exposure.exposure_us[i] =
        get_optional<double>(object, fmt::format("{}_us", kExposureNames[i]).c_str());
  }
  return exposure;
}

// Earlier recordings hold the number instead of the name, and nothing for "auto".
SensorLines sensor_lines_from_json(const json& object) {
  const auto found = object.find("sensor_lines");
  if (found == object.end()) return SensorLines::kAuto;
  for (std::size_t i = 0; i < kSensorLineNames.size(); ++i) {
    const bool named = found->is_string() && *found == kSensorLineNames[i];
    const bool numbered = found->is_number_integer() && *found == static_cast<int>(i);
    if (named || numbered) return static_cast<SensorLines>(i);
  }
  throw InputError("unknown sensor lines " + found->dump());
}

ScanRequest request_from_json(const json& object) {
  ScanRequest request;
  request.resolution_dpi = get_optional<int>(object, "resolution_dpi");
  const json area = object.value("area_mm", json::object());
  request.area.left_mm = get_optional<double>(area, "left");
  request.area.top_mm = get_optional<double>(area, "top");
  request.area.width_mm = get_optional<double>(area, "width");
  request.area.height_mm = get_optional<double>(area, "height");
  request.depth_bits = get_optional<int>(object, "depth_bits");
  request.infrared = object.value("infrared", true);
  request.focus = focus_from_json(object.value("focus", json::object()));
  request.exposure = exposure_from_json(object.value("exposure", json::object()));
  request.frame = object.value("frame", 1);
  request.frame_offset_mm = object.value("frame_offset_mm", 0.0);
  request.samples = object.value("samples", 1);
  request.sensor_lines = sensor_lines_from_json(object);
  request.overview = object.value("overview", false);
  return request;
}

}  // namespace

ordered_json request_to_json(const ScanRequest& request) {
  ordered_json object = ordered_json::object();
  put_optional(object, "resolution_dpi", request.resolution_dpi);
  ordered_json area = ordered_json::object();
  put_optional(area, "left", request.area.left_mm);
  put_optional(area, "top", request.area.top_mm);
  put_optional(area, "width", request.area.width_mm);
  put_optional(area, "height", request.area.height_mm);
  object["area_mm"] = area;
  put_optional(object, "depth_bits", request.depth_bits);
  object["infrared"] = request.infrared;
  constexpr std::array kFocusModes{"auto", "keep", "position"};
  ordered_json focus = {{"mode", kFocusModes[static_cast<std::size_t>(request.focus.mode)]}};
  if (request.focus.mode == FocusRequest::Mode::kPosition) {
    focus["position"] = request.focus.position;
  }
  put_optional(focus, "x_mm", request.focus.x_mm);
  put_optional(focus, "y_mm", request.focus.y_mm);
  object["focus"] = focus;
  const bool fixed = request.exposure.mode == ExposureRequest::Mode::kFixed;
  ordered_json exposure = {{"mode", fixed ? "fixed" : "meter"},
                           {"factor", request.exposure.factor}};
  for (std::size_t i = 0; i < kExposureNames.size(); ++i) {
    put_optional(exposure, fmt::format("{}_us", kExposureNames[i]).c_str(),
                 request.exposure.exposure_us[i]);
  }
  object["exposure"] = exposure;
  object["frame"] = request.frame;
  object["frame_offset_mm"] = request.frame_offset_mm;
  object["samples"] = request.samples;
  object["sensor_lines"] = kSensorLineNames[static_cast<std::size_t>(request.sensor_lines)];
  // Named only where asked for: neither belongs to an ordinary scan.
  if (!request.exposure.lock) object["exposure"]["lock"] = false;
  if (request.overview) object["overview"] = true;
  return object;
}

std::string recorded_request_to_json(const RecordedRequest& recorded) {
  const ordered_json object = {{"schema", kSchema},
                               {"device", recorded.device_name},
                               {"started_at_utc", recorded.started_at_utc},
                               {"request", request_to_json(recorded.request)}};
  return object.dump(-1, ' ', false, json::error_handler_t::replace);
}

std::optional<RecordedRequest> recorded_request_from_json(const std::string& text,
                                                          const std::string& source) {
  const json object = json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!object.is_object()) return std::nullopt;
  const auto schema = object.find("schema");
  if (schema == object.end() || !schema->is_string() || *schema != kSchema) return std::nullopt;
  try {
    RecordedRequest recorded;
    recorded.device_name = object.value("device", std::string());
    recorded.started_at_utc = object.value("started_at_utc", std::string());
    recorded.request = request_from_json(object.value("request", json::object()));
    return recorded;
  } catch (const json::exception& error) {
    throw InputError(
        fmt::format("{}: the recorded request cannot be understood ({}).", source, error.what()));
  } catch (const InputError& error) {
    throw InputError(
        fmt::format("{}: the recorded request cannot be understood ({}).", source, error.what()));
  }
}

}  // namespace reseau
