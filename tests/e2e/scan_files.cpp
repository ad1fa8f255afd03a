#include "tests/e2e/scan_files.h"

#include <stdexcept>

#include <tiffio.h>

#include "capture/image/scan_reader.h"

namespace reseau::testing {

Pixels read_pixels(const std::filesystem::path& path) {
  const Scan scan = read_scan(path);
  const LineFormat& format = scan.source->format();
  Pixels pixels{format.width_px, format.n_lines, format.n_channels(), {}};
  std::vector<std::uint16_t> line(format.samples_per_line());
  for (int y = 0; y < format.n_lines; ++y) {
    scan.source->read(y, 1, line);
    for (int x = 0; x < format.width_px; ++x) {
      for (int c = 0; c < format.n_channels(); ++c) {
        pixels.samples.push_back(line[static_cast<std::size_t>(c * format.width_px + x)]);
      }
    }
  }
  return pixels;
}

Pixels first_channels(const Pixels& pixels, int n) {
  Pixels result{pixels.width_px, pixels.height_px, n, {}};
  for (std::size_t i = 0; i < pixels.samples.size(); ++i) {
    if (i % static_cast<std::size_t>(pixels.n_channels) < static_cast<std::size_t>(n)) {
      result.samples.push_back(pixels.samples[i]);
    }
  }
  return result;
}

void write_tiff(const std::filesystem::path& path, const Pixels& pixels, int bits) {
  TIFF* const tiff = TIFFOpen(path.c_str(), "w");
  if (tiff == nullptr) throw std::runtime_error("cannot write " + path.string());
  const auto n_channels = static_cast<std::size_t>(pixels.n_channels);
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, pixels.width_px);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, pixels.height_px);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, pixels.n_channels);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, bits);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC,
               n_channels < 3 ? PHOTOMETRIC_MINISBLACK : PHOTOMETRIC_RGB);
  TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, pixels.height_px);
  if (n_channels == 4) {
    const std::uint16_t extra = EXTRASAMPLE_UNSPECIFIED;
    TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, 1, &extra);
  }
  const std::size_t per_row = static_cast<std::size_t>(pixels.width_px) * n_channels;
  std::vector<std::uint8_t> row8(per_row);
  for (int y = 0; y < pixels.height_px; ++y) {
    const std::uint16_t* const row = &pixels.samples[static_cast<std::size_t>(y) * per_row];
    std::vector<std::uint16_t> row16(row, row + per_row);
    for (std::size_t i = 0; i < per_row; ++i) row8[i] = static_cast<std::uint8_t>(row[i] / 257);
    void* const data = bits == 8 ? static_cast<void*>(row8.data()) : row16.data();
    TIFFWriteScanline(tiff, data, static_cast<std::uint32_t>(y), 0);
  }
  TIFFClose(tiff);
}

}  // namespace reseau::testing
