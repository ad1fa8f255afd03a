#include "capture/cli/units.h"

#include <charconv>
#include <cmath>
#include <initializer_list>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "core/base/error.h"

namespace reseau::cli {

namespace {

using Unit = std::pair<std::string_view, double>;

double parse_with_unit(const std::string& option, const std::string& text,
                       std::initializer_list<Unit> units, std::string_view example) {
  double number = 0;
  const char* const end = text.data() + text.size();
  const auto [rest, problem] = std::from_chars(text.data(), end, number);
  if (problem == std::errc{} && std::isfinite(number)) {
    std::string_view unit(rest, static_cast<std::size_t>(end - rest));
    while (!unit.empty() && unit.front() == ' ') unit.remove_prefix(1);
    if (unit.empty()) return number;
    for (const auto& [name, factor] : units) {
      if (unit == name) return number * factor;
    }
  }
  throw InputError(
      fmt::format("{} does not understand '{}'. Write it like {}.", option, text, example));
}

}  // namespace

int parse_dpi(const std::string& option, const std::string& text) {
  const double dpi = parse_with_unit(option, text, {{"dpi", 1.0}, {"ppi", 1.0}}, "4000dpi");
  if (dpi < 1 || dpi > 100000 || dpi != std::floor(dpi)) {
    throw InputError(
        fmt::format("{} {} is not a resolution. Write it like 4000dpi.", option, text));
  }
  return static_cast<int>(dpi);
}

double parse_mm(const std::string& option, const std::string& text) {
  return parse_with_unit(option, text, {{"mm", 1.0}, {"cm", 10.0}, {"in", 25.4}}, "12.5mm");
}

double parse_us(const std::string& option, const std::string& text) {
  return parse_with_unit(option, text, {{"us", 1.0}, {"µs", 1.0}, {"ms", 1000.0}}, "800us");
}

int parse_count(const std::string& option, const std::string& text, int least, int most) {
  int number = 0;
  const char* const end = text.data() + text.size();
  const auto [rest, problem] = std::from_chars(text.data(), end, number);
  if (problem != std::errc{} || rest != end || number < least || number > most) {
    throw InputError(
        fmt::format("{} takes a whole number from {} to {}, not '{}'.", option, least, most, text));
  }
  return number;
}

bool parse_yes_no(const std::string& option, const std::string& text) {
  for (const char* yes : {"yes", "on", "true", "1"}) {
    if (text == yes) return true;
  }
  for (const char* no : {"no", "off", "false", "0"}) {
    if (text == no) return false;
  }
  throw InputError(fmt::format("{} takes yes or no, not '{}'.", option, text));
}

}  // namespace reseau::cli
