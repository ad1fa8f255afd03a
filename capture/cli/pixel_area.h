// Areas of a picture as people type them.
#pragma once

#include <array>
#include <string>

namespace reseau::cli {

// "x,y,width,height" in whole pixels. InputError, naming the option, for anything else.
[[nodiscard]] std::array<int, 4> parse_pixel_area(const std::string& option,
                                                  const std::string& text);

}  // namespace reseau::cli
