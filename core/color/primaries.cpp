#include "core/color/primaries.h"

#include <algorithm>
#include <optional>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/color/adaptation.h"
#include "core/color/tables.h"

namespace reseau {
namespace {

constexpr std::array<std::string_view, 3> kElements{"red", "green", "blue"};

Spectrum element_transmittance(const SpectrumTable& table, std::string_view element) {
  std::vector<ChartPoint> points;
  for (const SpectrumRow& row : table.rows) {
    if (row.element == element) {
      points.push_back({row.wavelength_nm, row.transmittance_percent});
    }
  }
  Spectrum out = resample(points, observer_5nm().grid, 0.0, 100.0);
  for (double& value : out.values) {
    value /= 100.0;
  }
  return out;
}

const SpectrumTable* find_spectra(std::string_view name) {
  const auto tables = spectrum_tables();
  const auto found = std::find_if(tables.begin(), tables.end(),
                                  [name](const SpectrumTable& t) { return t.name == name; });
  return found == tables.end() ? nullptr : &*found;
}

Matrix3 integrate(const SpectrumTable& table, Illuminant light) {
  std::array<Xyz, 3> xyz{};
  for (std::size_t i = 0; i < 3; ++i) {
    xyz[i] = xyz_from_transmittance(element_transmittance(table, kElements[i]),
                                    illuminant_spectrum(light), observer_5nm());
  }
  return from_columns(xyz[0], xyz[1], xyz[2]);
}

struct StatedSet {
  Matrix3 xyz{};
  Illuminant illuminant = Illuminant::kE;
};

std::optional<StatedSet> find_chromaticities(std::string_view name) {
  std::array<Xyz, 3> xyz{};
  std::optional<Illuminant> illuminant;
  for (const ChromaticityRow& row : chromaticity_table()) {
    if (row.set != name) {
      continue;
    }
    const auto element = std::find(kElements.begin(), kElements.end(), row.element);
    CHECK(element != kElements.end());
    xyz[static_cast<std::size_t>(element - kElements.begin())] =
        xyz_from_chromaticity({row.x, row.y}, row.luminance);
    illuminant = parse_illuminant(row.illuminant);
  }
  if (!illuminant) {
    return std::nullopt;
  }
  return StatedSet{from_columns(xyz[0], xyz[1], xyz[2]), *illuminant};
}

[[noreturn]] void throw_unknown(std::string_view name) {
  std::string known;
  for (const std::string& each : primary_set_names()) {
    known += (known.empty() ? "" : ", ") + each;
  }
  throw InputError("There are no primaries called '" + std::string(name) +
                   "'; choose one of: " + known + ".");
}

}  // namespace

std::vector<std::string> primary_set_names() {
  std::vector<std::string> names;
  for (const SpectrumTable& table : spectrum_tables()) {
    names.emplace_back(table.name);
  }
  for (const ChromaticityRow& row : chromaticity_table()) {
    if (std::find(names.begin(), names.end(), row.set) == names.end()) {
      names.emplace_back(row.set);
    }
  }
  return names;
}

Matrix3 element_primaries(std::string_view name, Illuminant light) {
  if (const SpectrumTable* spectra = find_spectra(name)) {
    return integrate(*spectra, light);
  }
  if (const auto stated = find_chromaticities(name)) {
    if (stated->illuminant == light) {
      return stated->xyz;
    }
    return multiply(bradford_target_from_source(white_of(stated->illuminant), white_of(light)),
                    stated->xyz);
  }
  throw_unknown(name);
}

Matrix3 element_primaries_as_stated(std::string_view name, Illuminant light) {
  if (const auto stated = find_chromaticities(name)) {
    return stated->xyz;
  }
  return element_primaries(name, light);
}

Vector3 dufaycolor_areas() {
  Vector3 um2{};
  for (const GeometryRow& row : dufaycolor_geometry()) {
    const auto element = std::find(kElements.begin(), kElements.end(), row.element);
    CHECK(element != kElements.end());
    um2[static_cast<std::size_t>(element - kElements.begin())] =
        row.across_lines_um * row.along_lines_um;
  }
  const double total = um2[0] + um2[1] + um2[2];
  return {um2[0] / total, um2[1] / total, um2[2] / total};
}

}  // namespace reseau
