#include "tests/unit/color/reference_tables.h"

#include <fstream>
#include <sstream>
#include <stdexcept>

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

std::vector<CsvRow> read_reference_table(const std::string& name) {
  std::ifstream file(std::string(RESEAU_TEST_DATA_DIR) + "/color/" + name);
  if (!file) {
    throw std::runtime_error("cannot read " + name);
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

}  // namespace reseau
