// Where the channels of a scan lie against each other, without reconstructing it.
#pragma once

#include <stop_token>

#include "core/line/line_source.h"
#include "core/reconstruct/channel_offset.h"
#include "core/reconstruct/reconstruct.h"

namespace reseau {

// By the phases of the harmonics of a réseau that was found (channel_offsets). Throws what the
// source throws.
[[nodiscard]] ChannelOffsets measure_channel_offsets(const LineSource& source,
                                                     const Registration& registration,
                                                     const ToneCurves& tone,
                                                     const std::stop_token& stop);

}  // namespace reseau
