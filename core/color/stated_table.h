// Colours stated for the three elements, x y Y, from a table. Pure, reentrant.
#pragma once

#include <string>
#include <vector>

#include "core/color/color_csv.h"
#include "core/color/primary_set.h"

namespace reseau {

// [set,] element, x, y [, Y] [, illuminant]. `name` names a set where no column does. InputError, a
// sentence with the line, for what cannot be meant.
[[nodiscard]] std::vector<PrimarySet> stated_sets(const CsvText& table, const std::string& name);

}  // namespace reseau
