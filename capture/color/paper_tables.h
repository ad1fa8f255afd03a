// Parts of the paper's report that compare tables of colour differences.
#pragma once

#include <string>

#include "capture/color/paper.h"

namespace reseau {

// Tab. 3 and Tab. 4 on the fitted scenes, with their limits.
void add_difference_tables(PaperReport& report);
// What the text says of the tables.
void add_claims(PaperReport& report);

// Linear sRGB of the full elements of a printed set, for the picture of the réseau (Fig. 1b).
[[nodiscard]] Matrix3 paper_reseau_colors(const std::string& set);

}  // namespace reseau
