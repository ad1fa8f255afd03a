// A set of primaries: the colours of the red, green and blue elements of a screen, as printed
// spectra or as printed chromaticities, built in or a person's own. Pure functions, reentrant.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/color/adaptation.h"
#include "core/color/light.h"

namespace reseau {

enum class SpectralQuantity { kTransmittance, kDensity };

// Charts of the three elements, wavelengths rising: transmittance 0..1, or optical density.
// Readings of a print may lie a little outside; they are clamped after interpolation.
struct ElementCharts {
  SpectralQuantity quantity = SpectralQuantity::kTransmittance;
  std::array<std::vector<ChartPoint>, 3> points;
};

// Printed x, y, Y of the full elements under one light.
struct StatedColors {
  std::array<Chromaticity, 3> xy{};
  // Fractions. Absent where none are printed: then such that the three full elements together make
  // the white.
  std::optional<Vector3> luminance;
  std::optional<Light> light;  // absent: taken as they stand under any light
};

struct PrimarySet {
  std::string name;    // as `--primaries` knows it; the file's name for a person's own
  std::string about;   // what it is, a few words
  std::string source;  // where the numbers are printed
  // One of the two.
  std::optional<ElementCharts> charts;
  std::optional<StatedColors> stated;
  std::vector<std::string> notes;  // sentences: what was assumed on reading
};

// How much dye the elements hold, relative to the chart: density x (1 - fading) is the exponent on
// the transmittance (Beer-Lambert). 1 and 0 leave it as printed, fading 1 leaves clear film.
struct DyeState {
  Vector3 density{1, 1, 1};  // 0..10
  Vector3 fading{0, 0, 0};   // 0..1
  [[nodiscard]] bool as_printed() const;
};

// Under what the elements are seen.
struct Viewing {
  Light light = light_of(Illuminant::kD65);
  SummationStep step = SummationStep::k5nm;
  AdaptationMethod adaptation = AdaptationMethod::kBradford;  // for sets of stated colours
  DyeState dyes;
};

// Built in; the first is the default, "cornwell-clyne-1951".
[[nodiscard]] const std::vector<PrimarySet>& primary_sets();
[[nodiscard]] std::vector<std::string> primary_set_names();
// InputError for an unknown name, listing the known ones.
[[nodiscard]] const PrimarySet& find_primary_set(std::string_view name);

// Transmittance 0..1 of element 0..2 (red, green, blue) on a grid, dyes applied. The quantity that
// was charted is interpolated linearly, its outer segments continued, then clamped to 0..1 (density
// 0..9, its readings as well). The set must have charts (CHECK).
[[nodiscard]] Spectrum element_transmittance(const PrimarySet& set, std::size_t element,
                                             const WavelengthGrid& grid, const DyeState& dyes);

// XYZ of the full red, green and blue element (columns) under the light, whose own Y is 1; area not
// counted. InputError when dyes are changed of a set that has no spectra, and for dyes out of
// range.
[[nodiscard]] Matrix3 element_xyz(const PrimarySet& set, const Viewing& viewing);
// The same without adaptation: stated colours as printed.
[[nodiscard]] Matrix3 element_xyz_as_stated(const PrimarySet& set, const Viewing& viewing);

// A screen's shares of area, red green blue; they sum to 1.
struct ScreenAreas {
  std::string name;
  Vector3 share{};
};
// The first is "dufaycolor", from the micrograph's lengths.
[[nodiscard]] const std::vector<ScreenAreas>& screen_areas();
// A name from above, or three numbers "40,30,30" of any common scale. InputError otherwise.
[[nodiscard]] ScreenAreas parse_areas(std::string_view word);

// Single dyes that are listed and drawn, but make no set.
struct DyeChart {
  std::string name;
  std::vector<ChartPoint> points;  // transmittance 0..1
};
struct DyeTable {
  std::string name, source;
  std::vector<DyeChart> dyes;
};
[[nodiscard]] const std::vector<DyeTable>& dye_tables();

}  // namespace reseau
