// What a map says about a réseau in the words of a Registration.
#pragma once

#include <vector>

#include "core/line/line_format.h"
#include "core/reconstruct/reconstruct.h"
#include "core/screen/lattice_search.h"

namespace reseau {

// Lattice, periods and angle of result.map over the lines [0, n_lines); returns the mean plane
// [periods/px].
Mat2 describe_lattice(Registration& result, const LineFormat& format, int n_lines);
// Of the mean plane, from result.uncertainty.
void describe_certainty(Registration& result, const Mat2& mean);
// Screen and runner-up, with probabilities, from result.none_probability and the periods.
void describe_names(Registration& result, const LatticeSeed& seed,
                    const std::vector<PatternEvidence>& patterns = {});
// The printing of a Dufaycolor whose elements fit best, and how much better than the others.
void describe_printing(Registration& result, const std::vector<PatternEvidence>& patterns);
// Whether a map folds, or stretches the film threefold somewhere: then it is lost there.
[[nodiscard]] bool folds(const ScreenMap& map, const Mat2& mean, const LineFormat& format);

}  // namespace reseau
