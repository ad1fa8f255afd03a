#include "core/color/primary_set.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/color/primary_file.h"
#include "core/color/rgb_space.h"
#include "core/color/tables.h"

namespace reseau {
namespace {

std::vector<PrimarySet> read_built_in() {
  std::vector<PrimarySet> sets;
  const auto add = [&sets](std::vector<PrimarySet> more, const char* about) {
    for (PrimarySet& set : more) {
      const bool without_luminance = set.stated && !set.stated->luminance;
      set.about = without_luminance ? "printed x, y" : about;
      sets.push_back(std::move(set));
    }
  };
  for (const DataText& file : set_texts()) {
    add(parse_primary_sets(file.text, file.name, TableOrigin::kPublished), file.about);
  }
  // The sets of the paper first: the tables of Dufaycolor, then what else there is.
  std::stable_sort(sets.begin(), sets.end(), [](const PrimarySet& a, const PrimarySet& b) {
    const auto rank = [](const PrimarySet& set) {
      constexpr std::array<std::string_view, 7> kPaper{"cornwell-clyne-1951",
                                                       "harrison-horner-1939",
                                                       "collins-giles-1952",
                                                       "neblette-1952",
                                                       "cornwell-clyne-1951-tab1",
                                                       "hubicka-2025",
                                                       "srgb"};
      return std::find(kPaper.begin(), kPaper.end(), set.name) - kPaper.begin();
    };
    return rank(a) < rank(b);
  });
  return sets;
}

void require_dyes(const DyeState& dyes) {
  const auto within = [](double value, double highest) { return value >= 0 && value <= highest; };
  for (std::size_t i = 0; i < 3; ++i) {
    if (!within(dyes.density[i], 10)) {
      throw InputError("The density of a dye lies between 0 and 10 times the printed; correct it.");
    }
    if (!within(dyes.fading[i], 1)) {
      throw InputError("The fading of a dye lies between 0 (none) and 1 (all of it); correct it.");
    }
  }
}

Matrix3 stated_xyz(const StatedColors& stated, const Xyz& white) {
  if (!stated.luminance) {
    return xyz_from_rgb({{stated.xy[0], stated.xy[1], stated.xy[2], chromaticity_of(white)}});
  }
  const auto element = [&stated](std::size_t i) {
    return xyz_from_chromaticity(stated.xy[i], (*stated.luminance)[i]);
  };
  return from_columns(element(0), element(1), element(2));
}

Matrix3 charted_xyz(const PrimarySet& set, const Viewing& viewing) {
  const Observer& observer = observer_of(viewing.step);
  const Spectrum power = power_on(viewing.light, observer.grid);
  const auto element = [&](std::size_t i) {
    return xyz_from_transmittance(element_transmittance(set, i, observer.grid, viewing.dyes), power,
                                  observer);
  };
  return from_columns(element(0), element(1), element(2));
}

Xyz stated_white(const StatedColors& stated, const Viewing& viewing) {
  return white_of(stated.light ? *stated.light : viewing.light, viewing.step);
}

Matrix3 element_xyz_of(const PrimarySet& set, const Viewing& viewing, bool adapted) {
  require_dyes(viewing.dyes);
  if (set.charts) return charted_xyz(set, viewing);
  CHECK(set.stated);
  if (!viewing.dyes.as_printed()) {
    throw InputError("The set '" + set.name +
                     "' is given as colours, not as spectra, so its dyes cannot be changed; use a "
                     "set of spectra.");
  }
  const Xyz from = stated_white(*set.stated, viewing);
  const Matrix3 stated = stated_xyz(*set.stated, from);
  const Xyz to = white_of(viewing.light, viewing.step);
  if (!adapted || from == to) return stated;
  return multiply(target_from_source(viewing.adaptation, from, to), stated);
}

}  // namespace

bool DyeState::as_printed() const {
  return density == Vector3{1, 1, 1} && fading == Vector3{0, 0, 0};
}

const std::vector<PrimarySet>& primary_sets() {
  static const std::vector<PrimarySet> sets = read_built_in();
  return sets;
}

std::vector<std::string> primary_set_names() {
  std::vector<std::string> names;
  for (const PrimarySet& set : primary_sets()) names.push_back(set.name);
  return names;
}

const PrimarySet& find_primary_set(std::string_view name) {
  for (const PrimarySet& set : primary_sets()) {
    if (set.name == name) return set;
  }
  std::string known;
  for (const std::string& each : primary_set_names()) {
    known += (known.empty() ? "" : ", ") + each;
  }
  throw InputError("There are no primaries called '" + std::string(name) +
                   "'; choose one of: " + known + "; or give a CSV file of your own.");
}

Spectrum element_transmittance(const PrimarySet& set, std::size_t element,
                               const WavelengthGrid& grid, const DyeState& dyes) {
  CHECK(set.charts && element < 3);
  const bool density = set.charts->quantity == SpectralQuantity::kDensity;
  std::vector<ChartPoint> points = set.charts->points[element];
  const double highest = density ? kDeepestDensity : 1.0;
  if (density) {
    for (ChartPoint& point : points) point.value = std::clamp(point.value, 0.0, highest);
  }
  Spectrum out = resample(points, grid, 0, highest);
  const double dye = dyes.density[element] * (1 - dyes.fading[element]);
  if (!density && dye == 1) return out;
  for (double& value : out.values) {
    value = density ? std::pow(10.0, -dye * value) : std::pow(value, dye);
  }
  return out;
}

Matrix3 element_xyz(const PrimarySet& set, const Viewing& viewing) {
  return element_xyz_of(set, viewing, true);
}

Matrix3 element_xyz_as_stated(const PrimarySet& set, const Viewing& viewing) {
  return element_xyz_of(set, viewing, false);
}

const std::vector<ScreenAreas>& screen_areas() {
  static const std::vector<ScreenAreas> areas = [] {
    constexpr std::array<std::string_view, 3> kElements{"red", "green", "blue"};
    const auto shares = [](const Vector3& v) {
      const double total = v[0] + v[1] + v[2];
      return Vector3{v[0] / total, v[1] / total, v[2] / total};
    };
    Vector3 um2{};
    for (const GeometryRow& row : dufaycolor_geometry()) {
      const auto element = std::find(kElements.begin(), kElements.end(), row.element);
      CHECK(element != kElements.end());
      um2[static_cast<std::size_t>(element - kElements.begin())] =
          row.across_lines_um * row.along_lines_um;
    }
    std::vector<ScreenAreas> all{{"dufaycolor", shares(um2)}};
    for (const AreaRow& row : area_table()) {
      all.push_back({row.screen, shares({row.red_percent, row.green_percent, row.blue_percent})});
    }
    return all;
  }();
  return areas;
}

ScreenAreas parse_areas(std::string_view word) {
  std::string known;
  for (const ScreenAreas& screen : screen_areas()) {
    if (screen.name == word) return screen;
    known += (known.empty() ? "" : ", ") + screen.name;
  }
  Vector3 areas{};
  const char* at = word.data();
  const char* const end = at + word.size();
  bool good = true;
  for (std::size_t i = 0; i < 3 && good; ++i) {
    const auto [next, error] = std::from_chars(at, end, areas[i]);
    good = error == std::errc() && std::isfinite(areas[i]) && areas[i] > 0 &&
           (i == 2 ? next == end : next != end && *next == ',');
    at = next + (i == 2 ? 0 : 1);
  }
  const double total = areas[0] + areas[1] + areas[2];
  if (!good || !std::isfinite(total)) {
    throw InputError("There are no areas '" + std::string(word) +
                     "'; give three positive numbers such as 42,27,31, or one of: " + known + ".");
  }
  return {std::string(word), {areas[0] / total, areas[1] / total, areas[2] / total}};
}

const std::vector<DyeTable>& dye_tables() {
  static const std::vector<DyeTable> tables = [] {
    std::vector<DyeTable> all;
    for (const DataText& file : dye_texts()) all.push_back(parse_dye_table(file.text, file.name));
    return all;
  }();
  return tables;
}

}  // namespace reseau
