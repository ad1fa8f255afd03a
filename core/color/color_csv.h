// Tables of colour data as text: our own and a person's. Pure, reentrant.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace reseau {

struct CsvLine {
  int number = 0;  // in the text, from 1
  std::vector<std::string> fields;
};

struct CsvText {
  std::vector<std::string> comments;  // without '#'
  std::vector<std::string> columns;
  std::vector<CsvLine> rows;
  bool decimal_comma = false;
  std::vector<std::string> notes;  // sentences about what was assumed

  // Index of the first of these columns that is there (exact spelling), or nothing.
  [[nodiscard]] std::optional<std::size_t> column(
      std::initializer_list<std::string_view> names) const;
};

// Lines of fields below one header line. Takes a byte order mark, any line ends, '#' comments,
// blank lines, quotes around fields, and as separator semicolons, tabs or commas; with semicolons
// or tabs a decimal comma is understood and noted. InputError, with the line where there is one,
// for text that is empty, binary, without a header or rows, or whose rows have another number of
// fields than the header.
[[nodiscard]] CsvText parse_color_csv(std::string_view text);

// The text in quotes, cut where it is too long for a message.
[[nodiscard]] std::string csv_quoted(std::string_view text);

// A finite number, whatever the locale of the machine. `where` says what it is, for the message.
// InputError for anything else, an empty field and NaN included.
[[nodiscard]] double csv_number(const std::string& field, bool decimal_comma, int line,
                                std::string_view where);

}  // namespace reseau
