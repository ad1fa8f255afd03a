#pragma once

#include <string_view>

namespace reseau {

// The page: one document with its own style and script, which needs nothing but this server.
[[nodiscard]] std::string_view page_html();

}  // namespace reseau
