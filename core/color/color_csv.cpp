#include "core/color/color_csv.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/base/error.h"

namespace reseau {
namespace {

constexpr std::size_t kMostBytes = 16U << 20;

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\v\f\r\n";
  const auto first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

std::vector<std::string_view> lines_of(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const auto end = text.find_first_of("\r\n");
    lines.push_back(text.substr(0, end));
    if (end == std::string_view::npos) break;
    const bool both = text[end] == '\r' && end + 1 < text.size() && text[end + 1] == '\n';
    text.remove_prefix(end + (both ? 2 : 1));
  }
  return lines;
}

std::vector<std::string> fields_of(std::string_view line, char separator) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') {
      quoted = !quoted;
    } else if (c == separator && !quoted) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  for (std::string& field : fields) field = std::string(trimmed(field));
  return fields;
}

std::string at_line(int number) { return "Line " + std::to_string(number) + " of the table"; }

// A comma between digits of one field, where commas do not separate.
bool has_decimal_comma(const std::vector<std::string>& fields) {
  return std::any_of(fields.begin(), fields.end(), [](const std::string& field) {
    const auto comma = field.find(',');
    return comma != std::string::npos && !field.empty() &&
           field.find_first_not_of("+-0123456789.,eE") == std::string::npos;
  });
}

bool is_number(const std::string& field) {
  return field.find_first_of("0123456789") != std::string::npos &&
         field.find_first_not_of("+-0123456789.,eE") == std::string::npos;
}

void refuse_what_is_no_text(std::string_view text) {
  if (text.size() > kMostBytes) {
    throw InputError("The table is larger than 16 MB; a table of spectra is far smaller.");
  }
  if (text.find('\0') != std::string_view::npos) {
    throw InputError(
        "The table is not plain text (it holds zero bytes, as UTF-16 does); save it as CSV in "
        "UTF-8.");
  }
}

}  // namespace

std::optional<std::size_t> CsvText::column(std::initializer_list<std::string_view> names) const {
  for (const std::string_view name : names) {
    const auto found = std::find(columns.begin(), columns.end(), name);
    if (found != columns.end()) return static_cast<std::size_t>(found - columns.begin());
  }
  return std::nullopt;
}

CsvText parse_color_csv(std::string_view text) {
  refuse_what_is_no_text(text);
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.substr(0, 3) == kByteOrderMark) text.remove_prefix(3);

  CsvText table;
  char separator = ',';
  int number = 0;
  for (const std::string_view raw : lines_of(text)) {
    ++number;
    const std::string_view line = trimmed(raw);
    if (line.empty()) continue;
    if (line.front() == '#') {
      table.comments.emplace_back(trimmed(line.substr(1)));
      continue;
    }
    if (table.columns.empty()) {
      if (line.find(';') != std::string_view::npos) {
        separator = ';';
      } else if (raw.find('\t') != std::string_view::npos) {
        separator = '\t';
      }
      table.columns = fields_of(line, separator);
      if (std::all_of(table.columns.begin(), table.columns.end(), is_number)) {
        throw InputError(
            "The table has no header line; above the numbers write what its columns are, such as "
            "wavelength_nm,red,green,blue.");
      }
      continue;
    }
    if (separator == ',' && line.find(';') != std::string_view::npos) {
      throw InputError(at_line(number) +
                       " has semicolons and the header commas; separate all fields alike.");
    }
    CsvLine row{number, fields_of(separator == '\t' ? raw : line, separator)};
    if (row.fields.size() != table.columns.size()) {
      throw InputError(at_line(number) + " has " + std::to_string(row.fields.size()) +
                       " fields where the header has " + std::to_string(table.columns.size()) +
                       (separator == ','
                            ? "; with decimal commas, separate the fields by semicolons."
                            : "; give each row one field per column."));
    }
    table.decimal_comma =
        table.decimal_comma || (separator != ',' && has_decimal_comma(row.fields));
    table.rows.push_back(std::move(row));
  }
  if (table.columns.empty()) {
    throw InputError(
        "The table is empty; give a header line such as element,wavelength_nm,"
        "transmittance_percent, and rows below it.");
  }
  if (table.rows.empty()) {
    throw InputError("The table has a header line and nothing below it; add its rows.");
  }
  for (auto i = table.columns.begin(); i != table.columns.end(); ++i) {
    if (!i->empty() && std::find(table.columns.begin(), i, *i) != i) {
      throw InputError("The table has two columns called " + csv_quoted(*i) + "; rename one.");
    }
  }
  if (table.decimal_comma)
    table.notes.emplace_back("Commas in numbers are taken as decimal points.");
  return table;
}

std::string csv_quoted(std::string_view text) {
  constexpr std::size_t kLongest = 40;
  return "'" + std::string(text.substr(0, kLongest)) + (text.size() > kLongest ? "…'" : "'");
}

double csv_number(const std::string& field, bool decimal_comma, int line, std::string_view where) {
  std::string text = field;
  const bool mixed =
      decimal_comma && field.find(',') != std::string::npos && field.find('.') != std::string::npos;
  if (decimal_comma && !mixed) std::replace(text.begin(), text.end(), ',', '.');
  const char* first = text.data();
  const char* const last = first + text.size();
  if (first != last && *first == '+') ++first;
  double value = 0;
  const auto [end, error] = std::from_chars(first, last, value);
  if (field.empty()) {
    throw InputError(at_line(line) + ": there is no number for " + std::string(where) +
                     "; fill it in or leave the row out.");
  }
  if (mixed) {
    throw InputError(at_line(line) + ": " + csv_quoted(field) + " for " + std::string(where) +
                     " has a point and a comma; write numbers without marks between thousands.");
  }
  if (error != std::errc() || end != last || !std::isfinite(value)) {
    throw InputError(at_line(line) + ": " + csv_quoted(field) + " is no number for " +
                     std::string(where) + "; write it like 12.5.");
  }
  return value;
}

}  // namespace reseau
