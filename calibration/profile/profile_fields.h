// Fields of JSON objects, read with messages that name them. Part of profile_io.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/base/error.h"

namespace reseau::profile {

using Json = nlohmann::ordered_json;

[[nodiscard]] InputError wrong(const std::string& source, const std::string& field,
                               const char* what);

// Of one object. Refers to it.
class Fields {
 public:
  Fields(const Json& object, std::string source, std::string prefix);

  [[nodiscard]] std::string text(const char* name) const;
  [[nodiscard]] double number(const char* name) const;
  [[nodiscard]] std::optional<double> optional_number(const char* name) const;
  [[nodiscard]] std::vector<double> numbers(const char* name) const;
  [[nodiscard]] std::vector<std::string> texts(const char* name) const;
  [[nodiscard]] std::vector<bool> flags(const char* name) const;
  // Lists of `width` numbers each; none where the field is missing.
  [[nodiscard]] std::vector<std::vector<double>> rows(const char* name, std::size_t width) const;
  [[nodiscard]] std::optional<Fields> object(const char* name) const;
  [[nodiscard]] bool has(const char* name) const { return find(name) != nullptr; }
  [[nodiscard]] InputError error(const char* name, const char* what) const;

 private:
  [[nodiscard]] const Json* find(const char* name) const;
  [[nodiscard]] const Json& array(const char* name) const;
  [[nodiscard]] std::string full(const char* name) const;

  const Json& object_;
  std::string source_, prefix_;
};

}  // namespace reseau::profile
