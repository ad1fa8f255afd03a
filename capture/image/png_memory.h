#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace reseau {

// An 8-bit RGB PNG, tagged as sRGB, of [row][pixel][3]. For small pictures that go over a wire: all
// of it is in memory. Throws std::system_error where libpng fails.
[[nodiscard]] std::string encode_png(int width_px, int height_px,
                                     std::span<const std::uint8_t> rgb);

}  // namespace reseau
