#include "core/color/stated_table.h"

#include <algorithm>
#include <array>
#include <optional>

#include "core/base/error.h"
#include "core/color/dominant_wavelength.h"
#include "core/color/element_words.h"

namespace reseau {
namespace {

// Printed x, y may lie this far outside the spectral locus: two decimals, or a diagram read off.
constexpr double kPrintedChromaticity = 0.01;

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
      throw InputError(line_text(row.line) + ": " + kElementNames[row.element] + " of '" + name +
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
                          kElementNames[row.element] +
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
      throw InputError("The set '" + name + "' has no row for " + kElementNames[i] +
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

}  // namespace

std::vector<PrimarySet> stated_sets(const CsvText& table, const std::string& name) {
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

}  // namespace reseau
