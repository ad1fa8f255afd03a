// Sets of primaries from text: the tables of core/color/data and a person's own. Pure, reentrant.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/color/primary_set.h"

namespace reseau {

// Nothing that can be measured is darker; a density beyond it is a mistake of units.
inline constexpr double kDeepestDensity = 9;

// Published charts are taken with their gaps and short ends; of a person's own table these are
// noted, and refused where they leave too much open.
enum class TableOrigin { kPublished, kOwn };

// Understands three layouts, told by the header line (see core/color/README.md):
//   element, wavelength_nm, transmittance_percent | transmittance_fraction | optical_density
//   wavelength_nm, red, green, blue       (percent or fraction, told by the values)
//   [set,] element, x, y [, Y] [, illuminant]
// `name` names the set; with a column `set` there may be several, named by it. InputError, a
// sentence with the line or wavelength, for everything that cannot be meant: see the list there.
[[nodiscard]] std::vector<PrimarySet> parse_primary_sets(std::string_view text,
                                                         const std::string& name,
                                                         TableOrigin origin);

// Curves by name, for tables of single dyes: element, wavelength_nm, transmittance_percent.
[[nodiscard]] DyeTable parse_dye_table(std::string_view text, const std::string& name);

}  // namespace reseau
