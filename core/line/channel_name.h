// The words for channels in files, receipts and plans.
#pragma once

#include <cstddef>

#include "core/line/line_format.h"

namespace reseau {

// "red", "green", "blue", "infrared" or "grey".
[[nodiscard]] constexpr const char* channel_name(Channel channel) {
  constexpr const char* kNames[] = {"red", "green", "blue", "infrared", "grey"};
  return kNames[static_cast<std::size_t>(channel)];
}

}  // namespace reseau
