// Pictures in which nothing is a réseau, though much of it repeats: nature, textures, halftones,
// fabrics. Painted from a seed.
#pragma once

#include <cstdint>
#include <string>

#include "core/line/memory_line_source.h"

namespace reseau::test {

enum class NoScreen { kNature, kTexture, kHalftone, kFabric };

struct NoScreenPicture {
  std::string name;
  MemoryLineSource source;
};

// Picture `number` of a kind, side x side px; every third has no infrared.
[[nodiscard]] NoScreenPicture no_screen_picture(NoScreen kind, int number, int side_px);

}  // namespace reseau::test
