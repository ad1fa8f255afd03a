#pragma once

#include <string>
#include <vector>

#include "core/color/primary_set.h"

namespace reseau {

// Whether a word means a file rather than a built-in set.
[[nodiscard]] bool names_primaries_file(const std::string& word);

// What `--primaries` may be: the name of a built-in set; a CSV file of spectra or of x, y, Y
// (core/color/README.md says how it looks); or FILE#SET where a file holds several. InputError, a
// sentence that names the file, for anything else. Thread-safe.
[[nodiscard]] PrimarySet load_primary_set(const std::string& word);

// Rows r,g,b of linear element intensities, 0..1, in a CSV file. InputError as above.
[[nodiscard]] std::vector<Vector3> load_intensities(const std::string& path);

}  // namespace reseau
