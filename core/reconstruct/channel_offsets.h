// Offsets of the channels from the phases of the réseau's harmonics. Include from .cpp files only
// (Eigen).
#pragma once

#include "core/geometry/vec2.h"
#include "core/reconstruct/channel_offset.h"
#include "core/reconstruct/reconstruct.h"
#include "core/reconstruct/tile_blur.h"
#include "core/screen/screen_pattern.h"

namespace reseau {

// A channel sees all three elements, each in a share that is not known beforehand; but all of them
// lie evenly about (0, 0) of the map, so that whatever the shares are every harmonic h of a channel
// that is not shifted is real. A channel shifted by d turns it by 2 pi f_h . d, and nothing else
// does: neither blur that is even nor the picture, which errs to both sides. Where the elements of
// a screen do not lie evenly, shares and shift cannot be told apart; that is said. Deviations are
// from how the tiles scatter, those of differences from how they scatter together.
[[nodiscard]] ChannelOffsets channel_offsets(const MeasuredTiles& measured,
                                             const Registration& registration,
                                             const ScreenPattern& pattern, bool infrared,
                                             Vec2 frame_px);

}  // namespace reseau
