#include "core/color/chart_table.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/color/element_words.h"

namespace reseau {
namespace {

// What a chart must cover, and what it should: within 400..700 nm lies all but 0.1 % of Y.
constexpr double kMustBeginBy_nm = 420, kMustReach_nm = 660;
constexpr double kShouldBeginBy_nm = 405, kShouldReach_nm = 695;
// Between readings further apart a straight line is worth a word, and a guess.
constexpr double kWideGap_nm = 25, kWidestGap_nm = 100;
// Readings of a printed chart lie this much outside, no more.
constexpr double kReadingNoise = 0.02;

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
    throw InputError("The wavelengths run from " + nm_text(lowest) + " to " + nm_text(highest) +
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
      throw InputError(line_text(curve[i].line) + ": the wavelength " +
                       nm_text(curve[i].wavelength_nm) + " of " + element +
                       " is there twice; keep one of the two.");
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
                   " must rise, and " + nm_text((first_fall + 1)->wavelength_nm) + " follows " +
                   nm_text(first_fall->wavelength_nm) + "; sort the table or correct the number.");
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
                       nm_text(r.wavelength_nm) +
                       "; no filter does. Correct it or leave the row out.");
    }
    if (!density && value > 1 + kReadingNoise) {
      throw InputError(line_text(r.line) + ": " + element +
                       " lets through more than all light at " + nm_text(r.wavelength_nm) +
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
    throw InputError("The spectrum of " + element + " covers only " + nm_text(first) + " to " +
                     nm_text(last) + "; colours need at least " + nm_text(kMustBeginBy_nm) +
                     " to " + nm_text(kMustReach_nm) + ", better 400 to 700 nm.");
  }
  if (first > kShouldBeginBy_nm || last < kShouldReach_nm) {
    notes.push_back("The spectrum of " + element + " covers " + nm_text(first) + " to " +
                    nm_text(last) + "; beyond, its outer segments are continued.");
  }
  for (std::size_t i = 1; i < curve.size(); ++i) {
    const double a = curve[i - 1].wavelength_nm, b = curve[i].wavelength_nm;
    if (b - a <= kWideGap_nm || b < 400 || a > 700) continue;
    const std::string where = "Between " + nm_text(a) + " and " + nm_text(b) + " the spectrum of " +
                              element + " has no reading";
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
                                               kElementNames[i] + "; it needs red, green and blue."
                                         : std::string("The spectrum of ") + kElementNames[i] +
                                               " has one reading; give it more.");
    }
    require_nanometres(curves[i]);
    put_in_order(curves[i], kElementNames[i], own_notes);
  }
  const Unit unit = settle_unit(curves, said, own_notes);
  const double scale = unit == Unit::kPercent ? 100 : 1;
  ElementCharts charts;
  charts.quantity =
      unit == Unit::kDensity ? SpectralQuantity::kDensity : SpectralQuantity::kTransmittance;
  for (std::size_t i = 0; i < 3; ++i) {
    require_possible(curves[i], scale, unit == Unit::kDensity, kElementNames[i], own_notes);
    if (origin == TableOrigin::kOwn) require_coverage(curves[i], kElementNames[i], own_notes);
    for (const Reading& r : curves[i])
      charts.points[i].push_back({r.wavelength_nm, r.value / scale});
  }
  if (origin == TableOrigin::kOwn) notes.insert(notes.end(), own_notes.begin(), own_notes.end());
  return charts;
}

}  // namespace

PrimarySet charts_by_rows(const CsvText& table, std::size_t element, std::size_t wavelength,
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

PrimarySet charts_by_columns(const CsvText& table, std::size_t wavelength, TableOrigin origin) {
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
      throw InputError(std::string("The table has wavelengths and no column for ") +
                       kElementNames[k] + "; it needs red, green and blue.");
    }
    for (const CsvLine& row : table.rows) {
      curves[k].push_back(
          {csv_number(row.fields[wavelength], table.decimal_comma, row.number, "the wavelength"),
           csv_number(row.fields[*columns[k]], table.decimal_comma, row.number, kElementNames[k]),
           row.number});
    }
  }
  PrimarySet set;
  set.notes = table.notes;
  set.charts = checked_charts(std::move(curves), unit, origin, set.notes);
  return set;
}

}  // namespace reseau
