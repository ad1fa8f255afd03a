// The colour tables compiled into the library, as they stand in core/color/data (each file there
// names its source, quantity and unit). Immutable, thread-safe, valid for the life of the program.
#pragma once

#include <span>
#include <string_view>

namespace reseau {

// A whole file of data/ as text, for parse_primary_sets() and parse_dye_table().
struct DataText {
  const char* name;   // of the set, as `--primaries` knows it; of the file where it holds several
  const char* about;  // what the table describes, a few words
  std::string_view text;
};
// Words below are literals.
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
  const char* element;     // "red", "green" or "blue"
  double across_lines_um;  // across the red lines
  double along_lines_um;
};

struct AreaRow {
  const char* screen;
  double red_percent, green_percent, blue_percent;
};
struct ConeRow {
  const char* transform;
  double x, y, z;
};
struct RgbSpaceRow {
  const char* space;
  double red_x, red_y, green_x, green_y, blue_x, blue_y, white_x, white_y;
};

// CIEDE2000 between two sets of primaries.
struct DifferenceRow {
  const char* photograph;  // "fig3", "fig6"
  const char* balance;
  const char* set_a;
  const char* set_b;
  double mean, max;
};
struct CropDifferenceRow {
  const char* balance;
  const char* set_a;
  const char* set_b;
  double mean, max;
};

[[nodiscard]] std::span<const DataText> set_texts();  // spectra and chromaticities of elements
[[nodiscard]] std::span<const DataText> dye_texts();
[[nodiscard]] std::span<const ObserverRow> observer_table_1nm();   // 360..830 nm
[[nodiscard]] std::span<const ObserverRow> observer_table_5nm();   // 380..780 nm
[[nodiscard]] std::span<const IlluminantRow> illuminant_table();   // 380..780 nm, 5 nm
[[nodiscard]] std::span<const DaylightRow> daylight_table();       // 300..830 nm, 10 nm
[[nodiscard]] std::span<const GeometryRow> dufaycolor_geometry();  // red, green, blue
[[nodiscard]] std::span<const AreaRow> area_table();
[[nodiscard]] std::span<const ConeRow> cone_table();  // three rows per transform
[[nodiscard]] std::span<const RgbSpaceRow> rgb_space_table();
[[nodiscard]] std::span<const DifferenceRow> published_differences();  // 15 pairs, three times
[[nodiscard]] std::span<const CropDifferenceRow> color_screen_differences();

}  // namespace reseau
