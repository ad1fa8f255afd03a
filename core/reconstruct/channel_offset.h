// Where the channels of a scan lie against each other, by the réseau of the film. Plain values.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "core/geometry/vec2.h"

namespace reseau {

// What green sees at (x, y) the channel sees at (x, y) + at_px, in the middle of the frame.
struct ChannelOffset {
  Vec2 at_px, sd_px;
  // By how much that grows from the middle of the frame to its right border, and to its last line:
  // lateral colour, a stage that is not straight. Absent with few tiles.
  struct Growth {
    Vec2 along_x_px, along_x_sd_px, along_y_px, along_y_sd_px;
  };
  std::optional<Growth> growth;
};

struct ChannelOffsets {
  // R G B IR, green without; absent where the reason says why.
  std::array<std::optional<ChannelOffset>, 4> from_green;
  std::array<std::string, 4> reason;  // a sentence
  int tiles = 0;
};

}  // namespace reseau
