#include "tests/unit/color/reference_tables.h"

#include <fstream>
#include <sstream>

namespace reseau {
namespace {

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> fields;
  std::string field;
  std::istringstream stream(line);
  while (std::getline(stream, field, ',')) {
    fields.push_back(field);
  }
  return fields;
}

}  // namespace

std::optional<std::vector<CsvRow>> read_reference_table(const std::string& name) {
  std::ifstream file(std::string(RESEAU_SHARED_DIR) + "/data/colour/" + name);
  if (!file) {
    return std::nullopt;
  }
  std::vector<std::string> header;
  std::vector<CsvRow> rows;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line.front() == '#') {
      continue;
    }
    const auto fields = split(line);
    if (header.empty()) {
      header = fields;
      continue;
    }
    CsvRow row;
    for (std::size_t i = 0; i < header.size(); ++i) {
      row[header[i]] = i < fields.size() ? fields[i] : "";
    }
    rows.push_back(row);
  }
  return rows;
}

double number(const CsvRow& row, const std::string& column) { return std::stod(row.at(column)); }

std::string product_name(const std::string& reference_name) {
  static const std::map<std::string, std::string> names{
      {"tab1", "cornwell-clyne-1951-tab1"},
      {"tab2", "hubicka-2025"},
      {"harrison_horner", "harrison-horner-1939"},
      {"cornwell_clyne", "cornwell-clyne-1951"},
      {"collins_giles", "collins-giles-1952"},
      {"neblette", "neblette-1952"},
      {"srgb", "srgb"},
  };
  const auto found = names.find(reference_name);
  return found == names.end() ? "" : found->second;
}

}  // namespace reseau
