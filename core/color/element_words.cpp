#include "core/color/element_words.h"

#include <string_view>

#include "core/base/error.h"
#include "core/color/color_csv.h"

namespace reseau {

std::string nm_text(double wavelength_nm) {
  std::string text = std::to_string(wavelength_nm);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text + " nm";
}

std::string line_text(int number) { return "Line " + std::to_string(number) + " of the table"; }

std::optional<std::size_t> element_index(std::string word) {
  for (char& c : word) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  for (std::size_t i = 0; i < kElementNames.size(); ++i) {
    const std::string_view name = kElementNames[i];
    const bool whole = word == name || word == name.substr(0, 1);
    const bool begins = word.size() > name.size() && word.compare(0, name.size(), name) == 0 &&
                        !(word[name.size()] >= 'a' && word[name.size()] <= 'z');
    if (whole || begins) return i;
  }
  return std::nullopt;
}

std::size_t require_element(const std::string& word, int line) {
  const auto index = element_index(word);
  if (!index) {
    throw InputError(line_text(line) + ": " + csv_quoted(word) +
                     " is no element; call them red, green and blue.");
  }
  return *index;
}

}  // namespace reseau
