// Which of the screens that lie alike a scan shows: their elements differ in shape and size.
#pragma once

#include <vector>

#include "core/line/line_source.h"
#include "core/reconstruct/tone_curve.h"
#include "core/screen/screen_layout.h"
#include "core/screen/screen_map.h"

namespace reseau {

// Harmonics of some tiles of the scan against the elements of each of these screens, whose layout
// and colours the map is in: lights and blur are free, so that only shapes decide. Empty where
// there are less than two, or nothing to see. `period_px`: the larger one. Reads at most 16 tiles.
[[nodiscard]] std::vector<PatternEvidence> pattern_evidence(const LineSource& source,
                                                            const ToneCurves& tone,
                                                            const ScreenMap& map, double period_px,
                                                            const std::vector<ScreenKind>& kinds);

}  // namespace reseau
