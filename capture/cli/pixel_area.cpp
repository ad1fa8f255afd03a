#include "capture/cli/pixel_area.h"

#include <charconv>
#include <system_error>

#include <fmt/format.h>

#include "core/base/error.h"

namespace reseau::cli {

std::array<int, 4> parse_pixel_area(const std::string& option, const std::string& text) {
  std::array<int, 4> v{};
  const char* at = text.data();
  const char* const end = at + text.size();
  std::size_t n = 0;
  for (; n < v.size(); ++n) {
    const auto read = std::from_chars(at, end, v[n]);
    if (read.ec != std::errc()) break;
    at = read.ptr;
    if (n + 1 < v.size()) {
      if (at == end || *at != ',') break;
      ++at;
    }
  }
  if (n != v.size() || at != end) {
    throw InputError(
        fmt::format("{} takes whole pixels as x,y,width,height, not '{}'.", option, text));
  }
  return v;
}

}  // namespace reseau::cli
