#include "tests/support/tiff_planes.h"

#include <cstddef>
#include <cstdint>
#include <memory>

#include <tiffio.h>

namespace reseau::test {

Planes read_planes(const std::filesystem::path& path) {
  Planes out;
  const std::unique_ptr<TIFF, decltype(&TIFFClose)> file(TIFFOpen(path.c_str(), "r"), &TIFFClose);
  if (!file) return out;
  std::uint32_t w = 0, h = 0;
  std::uint16_t n = 1;
  TIFFGetField(file.get(), TIFFTAG_IMAGEWIDTH, &w);
  TIFFGetField(file.get(), TIFFTAG_IMAGELENGTH, &h);
  TIFFGetFieldDefaulted(file.get(), TIFFTAG_SAMPLESPERPIXEL, &n);
  out.width = static_cast<int>(w);
  out.height = static_cast<int>(h);
  out.samples.resize(n);
  std::vector<std::uint16_t> row(std::size_t{w} * n);
  for (std::uint32_t y = 0; y < h; ++y) {
    if (TIFFReadScanline(file.get(), row.data(), y) != 1) return {};
    for (std::size_t i = 0; i < row.size(); ++i) {
      out.samples[i % n].push_back(static_cast<float>(row[i]) / 65535);
    }
  }
  return out;
}

}  // namespace reseau::test
