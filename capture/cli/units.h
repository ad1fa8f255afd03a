// Numbers of the command line with the unit written behind them or left out.
#pragma once

#include <string>

namespace reseau::cli {

// "4000" or "4000dpi". Every InputError names the option and what it takes.
[[nodiscard]] int parse_dpi(const std::string& option, const std::string& text);
// "12.5", "12.5mm", "1.25cm", "0.5in" -> mm.
[[nodiscard]] double parse_mm(const std::string& option, const std::string& text);
// "800", "800us", "1.5ms" -> us.
[[nodiscard]] double parse_us(const std::string& option, const std::string& text);
// A whole number within [least, most].
[[nodiscard]] int parse_count(const std::string& option, const std::string& text, int least,
                              int most);
// "yes", "no", "on", "off", "true", "false", "1", "0".
[[nodiscard]] bool parse_yes_no(const std::string& option, const std::string& text);

}  // namespace reseau::cli
