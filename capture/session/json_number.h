// Numbers into JSON: JSON has no NaN and no infinity, and a silent null hides a fault.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace reseau {

// object[key] = value; a value that is not finite becomes null and `reason` is kept under
// object["not_available"][key].
void put_number(nlohmann::ordered_json& object, const std::string& key, double value,
                const std::string& reason = "not a finite number");
// object[key] = null with the reason.
void put_missing(nlohmann::ordered_json& object, const std::string& key, const std::string& reason);

// Whole numbers as such, others as they are; not finite: null. For arrays whose object says why.
[[nodiscard]] nlohmann::ordered_json number_or_null(double value);

}  // namespace reseau
