// Reference tables that lie beside the source tree on a maintainer's machine. Tests that need them
// are skipped elsewhere; every test of a figure also holds literal values.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace reseau {

using CsvRow = std::map<std::string, std::string>;  // column name to field

// Rows of a comma-separated table with `#` comments and a header line; nothing when it is absent.
std::optional<std::vector<CsvRow>> read_reference_table(const std::string& name);

double number(const CsvRow& row, const std::string& column);

// "tab1" -> "cornwell-clyne-1951-tab1" and so on; empty for a set the product does not hold.
std::string product_name(const std::string& reference_name);

}  // namespace reseau
