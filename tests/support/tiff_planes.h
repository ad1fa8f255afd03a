// The channels of a 16-bit TIFF, for what is measured on real scans.
#pragma once

#include <filesystem>
#include <vector>

namespace reseau::test {

struct Planes {
  int width = 0, height = 0;
  std::vector<std::vector<float>> samples;  // [channel][row * width + pixel], 1 = full scale
};

// Empty when the file cannot be read.
[[nodiscard]] Planes read_planes(const std::filesystem::path& path);

}  // namespace reseau::test
