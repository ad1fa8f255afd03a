// A path as sentences show it.
#pragma once

#include <filesystem>
#include <string>

namespace reseau {

inline std::string quoted(const std::filesystem::path& path) {
  std::string text("'");
  return text.append(path.string()).append("'");
}

}  // namespace reseau
