#include "core/color/primary_file.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/color/color_csv.h"
#include "core/color/dominant_wavelength.h"

namespace reseau {
namespace {

constexpr std::array<const char*, 3> kElements{"red", "green", "blue"};

// What a chart must cover, and what it should: within 400..700 nm lies all but 0.1 % of Y.
constexpr double kMustBeginBy_nm = 420, kMustReach_nm = 660;
constexpr double kShouldBeginBy_nm = 405, kShouldReach_nm = 695;
// Between readings further apart a straight line is worth a word, and a guess.
constexpr double kWideGap_nm = 25, kWidestGap_nm = 100;
// Readings of a printed chart lie this much outside, no more.
constexpr double kReadingNoise = 0.02;
// Printed x, y may lie this far outside the spectral locus: two decimals, or a diagram read off.
constexpr double kPrintedChromaticity = 0.01;

std::string nm(double wavelength_nm) {
  std::string text = std::to_string(wavelength_nm);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text + " nm";
}

std::string line_text(int number) { return "Line " + std::to_string(number) + " of the table"; }

// "red", "R", "red_25": the index of the element, or nothing.
std::optional<std::size_t> element_index(std::string word) {
  for (char& c : word) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  for (std::size_t i = 0; i < kElements.size(); ++i) {
    const std::string_view name = kElements[i];
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

struct Reading {
  double wavelength_nm = 0, value = 0;
  int line = 0;
};
using Readings = std::vector<Reading>;

enum class Unit { kPercent, kFraction, kDensity, kUnknown };

Unit unit_of_column(const std::string& name) {
  if (name.find("percent") != std::string::npos || name.find('%') != std::string::npos) {
    return Unit::kPercent;
  }
  if (name.find("density") != std::string::npos) return Unit::kDensity;
  if (name.find("fraction") != std::string::npos) return Unit::kFraction;
  return Unit::kUnknown;
}

void require_nanometres(const Readings& curve) {
  double lowest = curve.front().wavelength_nm, highest = lowest;
  for (const Reading& r : curve) {
    lowest = std::min(lowest, r.wavelength_nm);
    highest = std::max(highest, r.wavelength_nm);
  }
  if (lowest < 100 || highest > 4000) {
    const char* const guess = highest < 10     ? " They look like micrometres."
                              : lowest >= 2000 ? " They look like ångströms."
                                               : "";
    throw InputError("The wavelengths run from " + nm(lowest) + " to " + nm(highest) +
                     ", which cannot be light." + guess + " Give them in nanometres.");
  }
}

// Rising order; a table that runs from red to blue is turned round.
void put_in_order(Readings& curve, const std::string& element, std::vector<std::string>& notes) {
  const auto falls = [](const Reading& a, const Reading& b) {
    return b.wavelength_nm <= a.wavelength_nm;
  };
  const auto rises = [](const Reading& a, const Reading& b) {
    return b.wavelength_nm >= a.wavelength_nm;
  };
  for (std::size_t i = 1; i < curve.size(); ++i) {
    if (curve[i].wavelength_nm == curve[i - 1].wavelength_nm) {
      throw InputError(line_text(curve[i].line) + ": the wavelength " + nm(curve[i].wavelength_nm) +
                       " of " + element + " is there twice; keep one of the two.");
    }
  }
  const auto first_fall = std::adjacent_find(curve.begin(), curve.end(), falls);
  if (first_fall == curve.end()) return;
  if (std::adjacent_find(curve.begin(), curve.end(), rises) == curve.end()) {
    std::reverse(curve.begin(), curve.end());
    notes.push_back("The wavelengths of " + element + " fall; the table is read from its end.");
    return;
  }
  throw InputError(line_text((first_fall + 1)->line) + ": the wavelengths of " + element +
                   " must rise, and " + nm((first_fall + 1)->wavelength_nm) + " follows " +
                   nm(first_fall->wavelength_nm) + "; sort the table or correct the number.");
}

Unit settle_unit(const std::array<Readings, 3>& curves, Unit said,
                 std::vector<std::string>& notes) {
  double highest = 0;
  for (const Readings& curve : curves) {
    for (const Reading& r : curve) highest = std::max(highest, r.value);
  }
  if (said == Unit::kUnknown) {
    if (highest <= 1 + kReadingNoise) {
      notes.emplace_back("The table does not say its unit; it is taken as fractions of 1.");
      return Unit::kFraction;
    }
    if (highest > 2) {
      notes.emplace_back("The table does not say its unit; it is taken as percent.");
      return Unit::kPercent;
    }
    throw InputError("The table does not say its unit, and its largest value, " +
                     std::to_string(highest) +
                     ", is too much for a fraction and little for percent; name the column "
                     "transmittance_percent, transmittance_fraction or optical_density.");
  }
  if (said == Unit::kFraction && highest > 1 + kReadingNoise) {
    throw InputError("The table says fractions and goes up to " + std::to_string(highest) +
                     "; if these are percent, name the column transmittance_percent.");
  }
  if (said == Unit::kDensity && highest > kDeepestDensity) {
    throw InputError("The table says optical density and goes up to " + std::to_string(highest) +
                     ", which nothing has; if these are percent, name the column "
                     "transmittance_percent.");
  }
  if (said == Unit::kPercent && highest <= 1) {
    notes.emplace_back(
        "The table says percent, is taken as percent, and nowhere exceeds 1 %; if these are "
        "fractions, name the column transmittance_fraction.");
  }
  return said;
}

// Readings a little below nothing or above everything count as those; more is an error.
void require_possible(const Readings& curve, double scale, bool density, const std::string& element,
                      std::vector<std::string>& notes) {
  bool below = false, above = false;
  for (const Reading& r : curve) {
    const double value = r.value / scale;
    if (value < (density ? -0.05 : -kReadingNoise)) {
      throw InputError(line_text(r.line) + ": " + element + " has a negative value at " +
                       nm(r.wavelength_nm) + "; no filter does. Correct it or leave the row out.");
    }
    if (!density && value > 1 + kReadingNoise) {
      throw InputError(line_text(r.line) + ": " + element +
                       " lets through more than all light at " + nm(r.wavelength_nm) +
                       "; correct it or the unit.");
    }
    below = below || value < 0;
    above = above || (!density && value > 1);
  }
  if (below) notes.push_back("Values of " + element + " slightly below 0 count as 0.");
  if (above) notes.push_back("Values of " + element + " slightly above 100 % count as 100 %.");
}

void require_coverage(const Readings& curve, const std::string& element,
                      std::vector<std::string>& notes) {
  const double first = curve.front().wavelength_nm, last = curve.back().wavelength_nm;
  if (first > kMustBeginBy_nm || last < kMustReach_nm) {
    throw InputError("The spectrum of " + element + " covers only " + nm(first) + " to " +
                     nm(last) + "; colours need at least " + nm(kMustBeginBy_nm) + " to " +
                     nm(kMustReach_nm) + ", better 400 to 700 nm.");
  }
  if (first > kShouldBeginBy_nm || last < kShouldReach_nm) {
    notes.push_back("The spectrum of " + element + " covers " + nm(first) + " to " + nm(last) +
                    "; beyond, its outer segments are continued.");
  }
  for (std::size_t i = 1; i < curve.size(); ++i) {
    const double a = curve[i - 1].wavelength_nm, b = curve[i].wavelength_nm;
    if (b - a <= kWideGap_nm || b < 400 || a > 700) continue;
    const std::string where =
        "Between " + nm(a) + " and " + nm(b) + " the spectrum of " + element + " has no reading";
    if (b - a > kWidestGap_nm) throw InputError(where + "; that gap is too wide, fill it in.");
    notes.push_back(where + "; a straight line is drawn.");
  }
}

ElementCharts checked_charts(std::array<Readings, 3> curves, Unit said, TableOrigin origin,
                             std::vector<std::string>& notes) {
  std::vector<std::string> own_notes;
  for (std::size_t i = 0; i < 3; ++i) {
    if (curves[i].size() < 2) {
      throw InputError(curves[i].empty() ? std::string("The table has no rows for ") +
                                               kElements[i] + "; it needs red, green and blue."
                                         : std::string("The spectrum of ") + kElements[i] +
                                               " has one reading; give it more.");
    }
    require_nanometres(curves[i]);
    put_in_order(curves[i], kElements[i], own_notes);
  }
  const Unit unit = settle_unit(curves, said, own_notes);
  const double scale = unit == Unit::kPercent ? 100 : 1;
  ElementCharts charts;
  charts.quantity =
      unit == Unit::kDensity ? SpectralQuantity::kDensity : SpectralQuantity::kTransmittance;
  for (std::size_t i = 0; i < 3; ++i) {
    require_possible(curves[i], scale, unit == Unit::kDensity, kElements[i], own_notes);
    if (origin == TableOrigin::kOwn) require_coverage(curves[i], kElements[i], own_notes);
    for (const Reading& r : curves[i])
      charts.points[i].push_back({r.wavelength_nm, r.value / scale});
  }
  if (origin == TableOrigin::kOwn) notes.insert(notes.end(), own_notes.begin(), own_notes.end());
  return charts;
}

std::string source_of(const CsvText& table) {
  std::string source;
  for (const std::string& comment : table.comments) {
    if (!source.empty()) source += "\n";
    source += comment;
  }
  return source;
}

// element, wavelength, value
PrimarySet long_layout(const CsvText& table, std::size_t element, std::size_t wavelength,
                       TableOrigin origin) {
  std::optional<std::size_t> value;
  for (std::size_t i = 0; i < table.columns.size() && !value; ++i) {
    const std::string& name = table.columns[i];
    if (i != element && i != wavelength &&
        (unit_of_column(name) != Unit::kUnknown || name == "transmittance" || name == "value")) {
      value = i;
    }
  }
  if (!value) {
    throw InputError(
        "The table has no column of values; name it transmittance_percent, transmittance_fraction "
        "or optical_density.");
  }
  std::array<Readings, 3> curves;
  for (const CsvLine& row : table.rows) {
    const std::size_t i = require_element(row.fields[element], row.number);
    curves[i].push_back(
        {csv_number(row.fields[wavelength], table.decimal_comma, row.number, "the wavelength"),
         csv_number(row.fields[*value], table.decimal_comma, row.number, table.columns[*value]),
         row.number});
  }
  PrimarySet set;
  set.notes = table.notes;
  set.charts =
      checked_charts(std::move(curves), unit_of_column(table.columns[*value]), origin, set.notes);
  return set;
}

// wavelength, red, green, blue
PrimarySet wide_layout(const CsvText& table, std::size_t wavelength, TableOrigin origin) {
  std::array<std::optional<std::size_t>, 3> columns;
  Unit unit = unit_of_column(table.columns[wavelength]);
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    const auto element = element_index(table.columns[i]);
    if (i == wavelength || !element) continue;
    columns[*element] = i;
    const Unit own = unit_of_column(table.columns[i]);
    if (unit == Unit::kUnknown) unit = own;
    if (own != Unit::kUnknown && own != unit) {
      throw InputError("The columns name different units; give all three elements in one.");
    }
  }
  std::array<Readings, 3> curves;
  for (std::size_t k = 0; k < 3; ++k) {
    if (!columns[k]) {
      throw InputError(std::string("The table has wavelengths and no column for ") + kElements[k] +
                       "; it needs red, green and blue.");
    }
    for (const CsvLine& row : table.rows) {
      curves[k].push_back(
          {csv_number(row.fields[wavelength], table.decimal_comma, row.number, "the wavelength"),
           csv_number(row.fields[*columns[k]], table.decimal_comma, row.number, kElements[k]),
           row.number});
    }
  }
  PrimarySet set;
  set.notes = table.notes;
  set.charts = checked_charts(std::move(curves), unit, origin, set.notes);
  return set;
}

struct StatedRow {
  std::string set;
  std::size_t element = 0;
  Chromaticity xy{};
  std::optional<double> luminance;
  std::optional<Light> light;
  int line = 0;
};

StatedRow stated_row(const CsvText& table, const CsvLine& row, double luminance_scale) {
  const auto field = [&](std::optional<std::size_t> column) {
    return column ? row.fields[*column] : std::string();
  };
  StatedRow out;
  out.line = row.number;
  out.set = field(table.column({"set"}));
  out.element =
      require_element(field(table.column({"element", "filter", "colour", "color"})), row.number);
  out.xy = {csv_number(field(table.column({"x"})), table.decimal_comma, row.number, "x"),
            csv_number(field(table.column({"y"})), table.decimal_comma, row.number, "y")};
  if (!(out.xy[0] >= 0 && out.xy[1] > 0 && out.xy[0] + out.xy[1] <= 1 + 1e-9)) {
    throw InputError(line_text(row.number) +
                     ": x and y must be positive and not exceed 1 together; correct them.");
  }
  if (const std::string text = field(table.column({"Y", "Y_percent"})); !text.empty()) {
    out.luminance =
        csv_number(text, table.decimal_comma, row.number, "the luminance Y") / luminance_scale;
    if (!(*out.luminance > 0 && *out.luminance <= 1)) {
      throw InputError(
          line_text(row.number) +
          ": the luminance Y of an element lies above 0 and up to 1 (or 100 percent in "
          "a column Y_percent); correct it.");
    }
  }
  if (const std::string text = field(table.column({"illuminant", "white"})); !text.empty()) {
    try {
      out.light = parse_light(text);
    } catch (const InputError& error) {
      throw InputError(line_text(row.number) + ": " + error.what());
    }
  }
  return out;
}

// Percent when it is called that, or where some value exceeds 1.
double luminance_scale(const CsvText& table, std::vector<std::string>& notes) {
  if (table.column({"Y_percent"}) && !table.column({"Y"})) return 100;
  const auto column = table.column({"Y"});
  if (!column) return 1;
  double highest = 0;
  for (const CsvLine& row : table.rows) {
    if (row.fields[*column].empty()) continue;
    highest = std::max(highest, csv_number(row.fields[*column], table.decimal_comma, row.number,
                                           "the luminance Y"));
  }
  if (highest <= 1) return 1;
  if (highest <= 2) {
    throw InputError("The largest Y, " + std::to_string(highest) +
                     ", is too much for a fraction and little for percent; correct it, or name the "
                     "column Y_percent.");
  }
  notes.emplace_back("Some Y exceeds 1; they are taken as percent.");
  return 100;
}

std::string name_of(const std::optional<Light>& light) { return light ? light->name : ""; }

PrimarySet stated_set(const std::vector<StatedRow>& rows, const std::string& name) {
  PrimarySet set;
  set.name = name;
  StatedColors stated;
  std::array<bool, 3> seen{};
  Vector3 luminance{};
  std::size_t n_luminances = 0;
  for (const StatedRow& row : rows) {
    if (seen[row.element]) {
      throw InputError(line_text(row.line) + ": " + kElements[row.element] + " of '" + name +
                       "' is there twice; keep one of the two.");
    }
    seen[row.element] = true;
    stated.xy[row.element] = row.xy;
    if (row.luminance) {
      luminance[row.element] = *row.luminance;
      ++n_luminances;
    }
    if (!is_color_of_light(row.xy, observer_of(SummationStep::k5nm), kPrintedChromaticity)) {
      set.notes.push_back(line_text(row.line) + ": no light has the colour given for " +
                          kElements[row.element] +
                          "; it is used as it stands, but look whether x and y are right.");
    }
    if (name_of(row.light) != name_of(rows.front().light)) {
      throw InputError(line_text(row.line) + ": the elements of '" + name +
                       "' name different illuminants; they must be stated for one.");
    }
    stated.light = row.light;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    if (!seen[i]) {
      throw InputError("The set '" + name + "' has no row for " + kElements[i] +
                       "; it needs red, green and blue.");
    }
  }
  if (n_luminances != 0 && n_luminances != 3) {
    throw InputError("The set '" + name +
                     "' gives a luminance Y for some elements only; give all three or none.");
  }
  if (n_luminances == 3) {
    stated.luminance = luminance;
  } else {
    set.notes.emplace_back(
        "No luminances are given; they are taken such that the three full elements together make "
        "the white.");
  }
  if (!stated.light) {
    set.notes.emplace_back(
        "No illuminant is given; the colours are taken as they stand under any light.");
  }
  set.stated = stated;
  return set;
}

std::vector<PrimarySet> stated_layout(const CsvText& table, const std::string& name) {
  std::vector<std::string> notes = table.notes;
  const double scale = luminance_scale(table, notes);
  std::vector<std::string> names;
  std::vector<std::vector<StatedRow>> groups;
  for (const CsvLine& line : table.rows) {
    const StatedRow row = stated_row(table, line, scale);
    const auto found = std::find(names.begin(), names.end(), row.set);
    if (found == names.end()) {
      names.push_back(row.set);
      groups.push_back({row});
    } else {
      groups[static_cast<std::size_t>(found - names.begin())].push_back(row);
    }
  }
  std::vector<PrimarySet> sets;
  for (std::size_t i = 0; i < names.size(); ++i) {
    sets.push_back(stated_set(groups[i], names[i].empty() ? name : names[i]));
    sets.back().notes.insert(sets.back().notes.begin(), notes.begin(), notes.end());
  }
  return sets;
}

}  // namespace

std::vector<PrimarySet> parse_primary_sets(std::string_view text, const std::string& name,
                                           TableOrigin origin) {
  const CsvText table = parse_color_csv(text);
  const auto wavelength = table.column({"wavelength_nm", "wavelength", "nm", "lambda"});
  const auto element = table.column({"element", "filter", "colour", "color"});
  std::vector<PrimarySet> sets;
  if (wavelength) {
    sets.push_back(element ? long_layout(table, *element, *wavelength, origin)
                           : wide_layout(table, *wavelength, origin));
    sets.back().name = name;
  } else if (element && table.column({"x"}) && table.column({"y"})) {
    sets = stated_layout(table, name);
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
