#pragma once

#include <nlohmann/json.hpp>

#include "core/reconstruct/channel_offset.h"

namespace reseau {

// Where each channel lies against green [px], by the réseau, or the reason why it is not told.
[[nodiscard]] nlohmann::ordered_json channel_offsets_to_json(const ChannelOffsets& offsets);

}  // namespace reseau
