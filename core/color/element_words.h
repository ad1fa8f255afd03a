// The words that tables of primaries share: elements, wavelengths and lines, as a person reads
// them. Pure, reentrant.
#pragma once

#include <array>
#include <optional>
#include <string>

namespace reseau {

inline constexpr std::array<const char*, 3> kElementNames{"red", "green", "blue"};

// "420 nm", "420.5 nm".
[[nodiscard]] std::string nm_text(double wavelength_nm);

// "Line 7 of the table"
[[nodiscard]] std::string line_text(int number);

// "red", "R", "red_25": the index of the element, or nothing.
[[nodiscard]] std::optional<std::size_t> element_index(std::string word);

// The same; InputError with the line where the word is no element.
[[nodiscard]] std::size_t require_element(const std::string& word, int line);

}  // namespace reseau
