#include "capture/session/json_number.h"

#include <cmath>

namespace reseau {

void put_number(nlohmann::ordered_json& object, const std::string& key, double value,
                const std::string& reason) {
  if (std::isfinite(value)) {
    object[key] = value;
  } else {
    put_missing(object, key, reason);
  }
}

void put_missing(nlohmann::ordered_json& object, const std::string& key,
                 const std::string& reason) {
  object[key] = nullptr;
  object["not_available"][key] = reason;
}

nlohmann::ordered_json number_or_null(double value) {
  if (!std::isfinite(value)) return nullptr;
  return value;
}

}  // namespace reseau
