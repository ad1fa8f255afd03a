// Figures computed by another program, or published, to hold ours against: tests/data/color.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace reseau {

using CsvRow = std::map<std::string, std::string>;  // column name to field

// Rows of a comma-separated table with `#` comments and a header line. Throws when it is missing.
std::vector<CsvRow> read_reference_table(const std::string& name);

double number(const CsvRow& row, const std::string& column);

}  // namespace reseau
