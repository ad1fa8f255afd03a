// Pictures of every format that can be compared, made from a function of the place.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "capture/image/exr_file.h"

namespace reseau::compare {

using Pixel = std::array<double, 4>;  // R G B A (or the channels of an EXR), linear or encoded
using Paint = std::function<Pixel(int x, int y)>;

inline Paint flat(double r, double g, double b) {
  return [=](int, int) { return Pixel{r, g, b, 1}; };
}

struct ExrKind {
  std::vector<std::string> channels{"R", "G", "B"};
  ExrOptions options;
};
void write_exr(const std::filesystem::path& path, int width, int height, const Paint& paint,
               const ExrKind& kind = {});
[[nodiscard]] ExrKind xyz_exr();      // numbers are XYZ relative to D65
[[nodiscard]] ExrKind process_exr();  // of the default primaries, neutral

struct PngKind {
  bool sixteen_bit = false, alpha = false, srgb_chunk = true;
  double gamma = 0;  // 0 = no gAMA chunk
};
void write_png(const std::filesystem::path& path, int width, int height, const Paint& paint,
               const PngKind& kind = {});

struct TiffKind {
  int bits = 16, samples = 3;  // 32 bits: float
  bool planar = false, tiled = false, deflate = false;
  std::vector<std::byte> icc = {};
};
void write_tiff(const std::filesystem::path& path, int width, int height, const Paint& paint,
                const TiffKind& kind = {});

}  // namespace reseau::compare
