#include "core/color/primary_file.h"

#include "core/base/error.h"
#include "core/color/chart_table.h"
#include "core/color/color_csv.h"
#include "core/color/stated_table.h"

namespace reseau {
namespace {

std::string source_of(const CsvText& table) {
  std::string source;
  for (const std::string& comment : table.comments) {
    if (!source.empty()) source += "\n";
    source += comment;
  }
  return source;
}

}  // namespace

std::vector<PrimarySet> parse_primary_sets(std::string_view text, const std::string& name,
                                           TableOrigin origin) {
  const CsvText table = parse_color_csv(text);
  const auto wavelength = table.column({"wavelength_nm", "wavelength", "nm", "lambda"});
  const auto element = table.column({"element", "filter", "colour", "color"});
  std::vector<PrimarySet> sets;
  if (wavelength) {
    sets.push_back(element ? charts_by_rows(table, *element, *wavelength, origin)
                           : charts_by_columns(table, *wavelength, origin));
    sets.back().name = name;
  } else if (element && table.column({"x"}) && table.column({"y"})) {
    sets = stated_sets(table, name);
  } else {
    throw InputError(
        "The header line of the table is not understood. Give spectra as "
        "element,wavelength_nm,transmittance_percent or wavelength_nm,red,green,blue, or colours "
        "as element,x,y,Y,illuminant.");
  }
  for (PrimarySet& set : sets) set.source = source_of(table);
  return sets;
}

DyeTable parse_dye_table(std::string_view text, const std::string& name) {
  const CsvText table = parse_color_csv(text);
  const auto element = table.column({"element"});
  const auto wavelength = table.column({"wavelength_nm"});
  const auto value = table.column({"transmittance_percent"});
  if (!element || !wavelength || !value) {
    throw InputError("A table of dyes needs element, wavelength_nm and transmittance_percent.");
  }
  DyeTable out{name, source_of(table), {}};
  for (const CsvLine& row : table.rows) {
    const std::string& dye = row.fields[*element];
    if (out.dyes.empty() || out.dyes.back().name != dye) out.dyes.push_back({dye, {}});
    out.dyes.back().points.push_back(
        {csv_number(row.fields[*wavelength], false, row.number, "the wavelength"),
         csv_number(row.fields[*value], false, row.number, "the transmittance") / 100});
  }
  return out;
}

}  // namespace reseau
