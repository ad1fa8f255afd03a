#include "capture/image/tiff_pixels.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <tiffio.h>

#include "core/base/check.h"

namespace reseau {
namespace {

constexpr std::uint64_t kMaxTileBytes = std::uint64_t{256} << 20;

// From samples as libtiff delivers them to 16 bit.
class Converter {
 public:
  explicit Converter(const TiffPage& page) : page_(page) {}

  // n samples, `step` samples apart in the input, to a run of the output.
  void operator()(const std::uint8_t* in, std::size_t step, std::size_t n, std::uint16_t* out) {
    if (page_.bits == 8) {
      for (std::size_t i = 0; i < n; ++i) {
        out[i] = static_cast<std::uint16_t>(in[i * step] * 257);
      }
    } else if (page_.bits == 16) {
      for (std::size_t i = 0; i < n; ++i) std::memcpy(&out[i], in + i * step * 2, 2);
    } else {
      for (std::size_t i = 0; i < n; ++i) {
        float value = 0;
        std::memcpy(&value, in + i * step * 4, 4);
        out[i] = from_float(value);
      }
    }
  }
  [[nodiscard]] std::size_t sample_bytes() const {
    return static_cast<std::size_t>(page_.bits) / 8;
  }
  [[nodiscard]] std::uint64_t n_clamped() const { return n_clamped_; }

 private:
  std::uint16_t from_float(float value) {
    if (!(value >= 0.0F && value <= 1.0F)) {
      ++n_clamped_;
      value = value > 1.0F ? 1.0F : 0.0F;  // NaN: 0
    }
    return static_cast<std::uint16_t>(std::lround(static_cast<double>(value) * 65535.0));
  }

  const TiffPage& page_;
  std::uint64_t n_clamped_ = 0;
};

// Where things lie in the result.
struct Target {
  std::vector<std::uint16_t>& samples;
  std::size_t width, channels;
  [[nodiscard]] std::uint16_t* at(std::size_t line, std::size_t channel, std::size_t x) {
    return samples.data() + (line * channels + channel) * width + x;
  }
};

int read_strips(TIFF* tiff, const TiffPage& page, int n_lines, Converter& convert, Target target) {
  const auto scanline = TIFFScanlineSize64(tiff);
  const std::size_t planes = page.planar ? target.channels : 1;
  const std::size_t per_plane = target.channels / planes;
  if (scanline < target.width * per_plane * convert.sample_bytes()) return 0;
  std::vector<std::uint8_t> row(scanline);
  // Plane by plane, since a compressed strip can only be read forwards.
  for (std::size_t plane = 0; plane < planes; ++plane) {
    for (int y = 0; y < n_lines; ++y) {
      if (TIFFReadScanline(tiff, row.data(), static_cast<std::uint32_t>(y),
                           static_cast<std::uint16_t>(plane)) != 1) {
        n_lines = y;
        break;
      }
      for (std::size_t c = 0; c < per_plane; ++c) {
        convert(row.data() + c * convert.sample_bytes(), per_plane, target.width,
                target.at(static_cast<std::size_t>(y), plane + c, 0));
      }
    }
  }
  return n_lines;
}

int read_tiles(TIFF* tiff, const TiffPage& page, int n_lines, Converter& convert, Target target) {
  std::uint32_t tile_width = 0, tile_height = 0;
  TIFFGetField(tiff, TIFFTAG_TILEWIDTH, &tile_width);
  TIFFGetField(tiff, TIFFTAG_TILELENGTH, &tile_height);
  const std::uint64_t tile_bytes = TIFFTileSize64(tiff);
  const std::size_t planes = page.planar ? target.channels : 1;
  const std::size_t per_plane = target.channels / planes;
  const std::size_t tile_row_bytes = tile_width * per_plane * convert.sample_bytes();
  if (tile_width == 0 || tile_height == 0 || tile_bytes > kMaxTileBytes ||
      tile_bytes < tile_row_bytes * tile_height) {
    return 0;
  }
  std::vector<std::uint8_t> tile(tile_bytes);
  for (int y = 0; y < n_lines; y += static_cast<int>(tile_height)) {
    for (std::size_t x = 0; x < target.width; x += tile_width) {
      for (std::size_t plane = 0; plane < planes; ++plane) {
        if (TIFFReadTile(tiff, tile.data(), static_cast<std::uint32_t>(x),
                         static_cast<std::uint32_t>(y), 0, static_cast<std::uint16_t>(plane)) < 0) {
          return y;
        }
        const std::size_t columns = std::min<std::size_t>(tile_width, target.width - x);
        const int rows = std::min(static_cast<int>(tile_height), n_lines - y);
        for (int i = 0; i < rows; ++i) {
          const auto* in = tile.data() + static_cast<std::size_t>(i) * tile_row_bytes;
          for (std::size_t c = 0; c < per_plane; ++c) {
            convert(
                in + c * convert.sample_bytes(), per_plane, columns,
                target.at(static_cast<std::size_t>(y) + static_cast<std::size_t>(i), plane + c, x));
          }
        }
      }
    }
  }
  return n_lines;
}

}  // namespace

std::string unsupported_reason(const TiffPage& page) {
  const bool integer = page.is_unsigned && (page.bits == 8 || page.bits == 16);
  if (!integer && !(page.is_float && page.bits == 32)) {
    return "its samples have " + std::to_string(page.bits) + " bits" +
           (page.is_float      ? " of floating point"
            : page.is_unsigned ? ""
                               : " with a sign") +
           ", where 8 or 16 bits or 32-bit floating point are understood";
  }
  const bool grey = page.photometric == PHOTOMETRIC_MINISBLACK;
  const bool rgb = page.photometric == PHOTOMETRIC_RGB || page.photometric == PHOTOMETRIC_YCBCR;
  if (!grey && !rgb) {
    return "its colour model (PhotometricInterpretation " + std::to_string(page.photometric) +
           ") is neither RGB nor grey";
  }
  if (page.photometric == PHOTOMETRIC_YCBCR && !(page.compressed && page.samples == 3)) {
    return "it holds luminance and colour differences instead of RGB";
  }
  return {};
}

TiffPixels decode_page(TiffFile& file) {
  const TiffPage& page = file.page();
  CHECK(unsupported_reason(page).empty());
  // Only JPEG knows this tag; with it the codec itself turns YCbCr into RGB.
  std::uint16_t compression = COMPRESSION_NONE;
  TIFFGetFieldDefaulted(file.handle(), TIFFTAG_COMPRESSION, &compression);
  if (page.photometric == PHOTOMETRIC_YCBCR) {
    if (compression != COMPRESSION_JPEG) return {};
    TIFFSetField(file.handle(), TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
  }

  TiffPixels pixels;
  const auto width = static_cast<std::size_t>(page.width_px);
  const auto channels = static_cast<std::size_t>(page.samples);
  pixels.samples.resize(static_cast<std::size_t>(page.lines_in_file) * channels * width);
  Converter convert(page);
  const Target target{pixels.samples, width, channels};
  pixels.n_lines = page.tiled
                       ? read_tiles(file.handle(), page, page.lines_in_file, convert, target)
                       : read_strips(file.handle(), page, page.lines_in_file, convert, target);
  pixels.n_clamped = convert.n_clamped();
  pixels.samples.resize(static_cast<std::size_t>(pixels.n_lines) * channels * width);
  return pixels;
}

}  // namespace reseau
