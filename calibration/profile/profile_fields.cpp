#include "calibration/profile/profile_fields.h"

#include <utility>

namespace reseau::profile {

InputError wrong(const std::string& source, const std::string& field, const char* what) {
  return InputError("The calibration profile '" + source + "': the field '" + field + "' " + what +
                    ".");
}

Fields::Fields(const Json& object, std::string source, std::string prefix)
    : object_(object), source_(std::move(source)), prefix_(std::move(prefix)) {
  if (!object_.is_object()) {
    throw wrong(source_, prefix_.empty() ? "(whole file)" : prefix_, "must be an object");
  }
}

std::string Fields::text(const char* name) const {
  const Json* value = find(name);
  if (value == nullptr) return {};
  if (!value->is_string()) throw wrong(source_, full(name), "must be text");
  return value->get<std::string>();
}

double Fields::number(const char* name) const {
  const Json* value = find(name);
  if (value == nullptr || !value->is_number()) {
    throw wrong(source_, full(name), "must be a number");
  }
  return value->get<double>();
}

std::optional<double> Fields::optional_number(const char* name) const {
  if (!has(name)) return std::nullopt;
  return number(name);
}

std::vector<double> Fields::numbers(const char* name) const {
  std::vector<double> out;
  for (const Json& value : array(name)) {
    if (!value.is_number()) throw wrong(source_, full(name), "must hold numbers only");
    out.push_back(value.get<double>());
  }
  return out;
}

std::vector<std::string> Fields::texts(const char* name) const {
  std::vector<std::string> out;
  if (find(name) == nullptr) return out;
  for (const Json& value : array(name)) {
    if (!value.is_string()) throw wrong(source_, full(name), "must hold texts only");
    out.push_back(value.get<std::string>());
  }
  return out;
}

std::vector<bool> Fields::flags(const char* name) const {
  std::vector<bool> out;
  for (const Json& value : array(name)) {
    if (!value.is_boolean()) throw wrong(source_, full(name), "must hold true and false only");
    out.push_back(value.get<bool>());
  }
  return out;
}

std::vector<std::vector<double>> Fields::rows(const char* name, std::size_t width) const {
  std::vector<std::vector<double>> out;
  if (!has(name)) return out;
  for (const Json& row : array(name)) {
    std::vector<double>& values = out.emplace_back();
    for (const Json& value : row) {
      if (!value.is_number()) throw wrong(source_, full(name), "must hold numbers only");
      values.push_back(value.get<double>());
    }
    if (!row.is_array() || values.size() != width) {
      throw wrong(source_, full(name), "must hold lists of the right length");
    }
  }
  return out;
}

std::optional<Fields> Fields::object(const char* name) const {
  const Json* value = find(name);
  if (value == nullptr) return std::nullopt;
  return Fields(*value, source_, full(name));
}

InputError Fields::error(const char* name, const char* what) const {
  return wrong(source_, full(name), what);
}

const Json* Fields::find(const char* name) const {
  const auto it = object_.find(name);
  return it == object_.end() || it->is_null() ? nullptr : &*it;
}

const Json& Fields::array(const char* name) const {
  const Json* value = find(name);
  if (value == nullptr || !value->is_array()) throw wrong(source_, full(name), "must be a list");
  return *value;
}

std::string Fields::full(const char* name) const {
  return prefix_.empty() ? name : prefix_ + "." + name;
}

}  // namespace reseau::profile
