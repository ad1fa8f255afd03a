// Charts of the three elements from a table. Pure, reentrant.
#pragma once

#include <cstddef>

#include "core/color/color_csv.h"
#include "core/color/primary_file.h"
#include "core/color/primary_set.h"

namespace reseau {

// element, wavelength_nm, transmittance_percent | transmittance_fraction | optical_density. The
// columns of the element and of the wavelength are given, that of the values is found by its name.
// InputError, a sentence with line or wavelength, for what cannot be meant.
[[nodiscard]] PrimarySet charts_by_rows(const CsvText& table, std::size_t element,
                                        std::size_t wavelength, TableOrigin origin);

// wavelength_nm, red, green, blue. As above.
[[nodiscard]] PrimarySet charts_by_columns(const CsvText& table, std::size_t wavelength,
                                           TableOrigin origin);

}  // namespace reseau
