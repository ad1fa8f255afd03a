#pragma once

#include <filesystem>
#include <string>

namespace reseau {

// SHA-256 of a file's bytes, 64 lower-case hexadecimal digits. Throws std::system_error.
[[nodiscard]] std::string sha256_of_file(const std::filesystem::path& path);

}  // namespace reseau
