// Which of the screens that lie alike a scan shows: their elements differ in shape and size.
#pragma once

#include <vector>

#include "core/line/line_source.h"
#include "core/reconstruct/tone_curve.h"
#include "core/screen/screen_layout.h"
#include "core/screen/screen_map.h"

namespace reseau {

// Harmonics of some tiles of the scan against the elements of each screen of the layout whose odd
// colour is special_color: lights and blur are free, so that only shapes decide. Empty where there
// is one such screen, or nothing to see. `period_px`: the larger one. Reads at most 16 tiles.
[[nodiscard]] std::vector<PatternEvidence> pattern_evidence(const LineSource& source,
                                                            const ToneCurves& tone,
                                                            const ScreenMap& map, double period_px,
                                                            ScreenLayout layout, int special_color);

}  // namespace reseau
