// The colour tables compiled into the library, as they stand in core/color/data (each file there
// names its source, quantity and unit). Immutable, thread-safe, valid for the life of the program.
#pragma once

#include <span>

namespace reseau {

// Words are literals: `element` is "red", "green" or "blue".
struct SpectrumRow {
  const char* element;
  double wavelength_nm;
  double transmittance_percent;
};
struct ChromaticityRow {
  const char* set;
  const char* element;
  double x, y;
  double luminance;        // Y of the full element, fraction
  const char* illuminant;  // under which it was stated
};
struct ObserverRow {
  double wavelength_nm;
  double xbar, ybar, zbar;
};
struct IlluminantRow {
  double wavelength_nm;
  double a, b, c, d50, d65, e;
};
struct DaylightRow {
  double wavelength_nm;
  double s0, s1, s2;
};
struct GeometryRow {
  const char* element;
  double across_lines_um;  // across the red lines
  double along_lines_um;
};

// Spectra of one printed source: all rows of red, then green, then blue in any order, wavelengths
// rising within an element.
struct SpectrumTable {
  const char* name;      // as `--primaries` knows it
  const char* citation;  // the printed source, short
  std::span<const SpectrumRow> rows;
};

[[nodiscard]] std::span<const SpectrumTable> spectrum_tables();
[[nodiscard]] std::span<const ChromaticityRow> chromaticity_table();
[[nodiscard]] std::span<const ObserverRow> observer_table_1nm();   // 360..830 nm
[[nodiscard]] std::span<const ObserverRow> observer_table_5nm();   // 380..780 nm
[[nodiscard]] std::span<const IlluminantRow> illuminant_table();   // 380..780 nm, 5 nm
[[nodiscard]] std::span<const DaylightRow> daylight_table();       // 300..830 nm, 10 nm
[[nodiscard]] std::span<const GeometryRow> dufaycolor_geometry();  // red, green, blue

}  // namespace reseau
