// TIFF files of every kind that people have, made from one simulated film.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace reseau::testing {

struct Pixels {
  int width_px = 0, height_px = 0, n_channels = 0;
  std::vector<std::uint16_t> samples;  // [row][pixel][channel]
};

[[nodiscard]] Pixels read_pixels(const std::filesystem::path& path);
// The first n channels only.
[[nodiscard]] Pixels first_channels(const Pixels& pixels, int n);
// bits: 8 or 16. Chunky, one strip.
void write_tiff(const std::filesystem::path& path, const Pixels& pixels, int bits);

}  // namespace reseau::testing
