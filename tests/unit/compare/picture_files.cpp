#include "tests/unit/compare/picture_files.h"

#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstdint>
#include <cstdio>
#include <cstring>

#include <gtest/gtest.h>
#include <png.h>
#include <tiffio.h>

#include "core/color/element_color.h"

namespace reseau::compare {
namespace {

std::uint16_t integer(double v, int full) {
  return static_cast<std::uint16_t>(std::lround(std::clamp(v, 0.0, 1.0) * full));
}

void put_sample(std::vector<std::uint8_t>& out, double v, int bits) {
  if (bits == 8) {
    out.push_back(static_cast<std::uint8_t>(integer(v, 255)));
  } else if (bits == 16) {
    const std::uint16_t i = integer(v, 65535);
    out.resize(out.size() + 2);
    std::memcpy(out.data() + out.size() - 2, &i, 2);
  } else {
    const auto f = static_cast<float>(v);
    out.resize(out.size() + 4);
    std::memcpy(out.data() + out.size() - 4, &f, 4);
  }
}

}  // namespace

void write_exr(const std::filesystem::path& path, int width, int height, const Paint& paint,
               const ExrKind& kind) {
  FloatImageWriter writer(path, width, height, kind.channels, kind.options);
  std::vector<float> row;
  for (int y = 0; y < height; ++y) {
    row.clear();
    for (int x = 0; x < width; ++x) {
      const Pixel p = paint(x, y);
      for (std::size_t k = 0; k < kind.channels.size(); ++k)
        row.push_back(static_cast<float>(p[k]));
    }
    writer.rows(y, 1, row);
  }
  writer.finish();
}

ExrKind xyz_exr() {
  ExrKind kind;
  kind.options.chromaticities =
      make_color_model(primary_set_names().front(), Balance::kNeutral, OutputSpace::kXyz)
          .chromaticities;
  return kind;
}

ExrKind process_exr() {
  ExrKind kind;
  kind.options.chromaticities =
      make_color_model(primary_set_names().front(), Balance::kNeutral, OutputSpace::kProcess)
          .chromaticities;
  kind.options.attributes = {{"reseau.space", "process"},
                             {"reseau.primaries", primary_set_names().front()},
                             {"reseau.balance", "neutral"}};
  return kind;
}

void write_png(const std::filesystem::path& path, int width, int height, const Paint& paint,
               const PngKind& kind) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  ASSERT_NE(file, nullptr);
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  std::vector<std::uint8_t> row;
  ASSERT_EQ(setjmp(png_jmpbuf(png)), 0);
  png_init_io(png, file);
  png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height),
               kind.sixteen_bit ? 16 : 8, kind.alpha ? PNG_COLOR_TYPE_RGBA : PNG_COLOR_TYPE_RGB,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  if (kind.srgb_chunk) png_set_sRGB(png, info, PNG_sRGB_INTENT_RELATIVE);
  if (kind.gamma > 0) png_set_gAMA(png, info, kind.gamma);
  png_write_info(png, info);
  for (int y = 0; y < height; ++y) {
    row.clear();
    for (int x = 0; x < width; ++x) {
      const Pixel p = paint(x, y);
      for (std::size_t k = 0; k < (kind.alpha ? 4U : 3U); ++k) {
        const std::uint16_t v = integer(p[k], kind.sixteen_bit ? 65535 : 255);
        if (kind.sixteen_bit) row.push_back(static_cast<std::uint8_t>(v >> 8));
        row.push_back(static_cast<std::uint8_t>(v & 0xFF));
      }
    }
    png_write_row(png, row.data());
  }
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  std::fclose(file);
}

void write_tiff(const std::filesystem::path& path, int width, int height, const Paint& paint,
                const TiffKind& kind) {
  TIFF* tiff = TIFFOpen(path.c_str(), "w");
  ASSERT_NE(tiff, nullptr);
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, width);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, height);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, kind.bits);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, kind.samples);
  TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT,
               kind.bits == 32 ? SAMPLEFORMAT_IEEEFP : SAMPLEFORMAT_UINT);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC,
               kind.samples < 3 ? PHOTOMETRIC_MINISBLACK : PHOTOMETRIC_RGB);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG,
               kind.planar ? PLANARCONFIG_SEPARATE : PLANARCONFIG_CONTIG);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION,
               kind.deflate ? COMPRESSION_ADOBE_DEFLATE : COMPRESSION_NONE);
  if (kind.samples == 4) {
    const std::uint16_t extra = EXTRASAMPLE_UNSPECIFIED;
    TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, 1, &extra);
  }
  if (!kind.icc.empty()) {
    TIFFSetField(tiff, TIFFTAG_ICCPROFILE, static_cast<std::uint32_t>(kind.icc.size()),
                 kind.icc.data());
  }
  const auto n = static_cast<std::size_t>(kind.samples);
  std::vector<std::uint8_t> row;
  if (kind.tiled) {
    constexpr int kTile = 16;
    TIFFSetField(tiff, TIFFTAG_TILEWIDTH, kTile);
    TIFFSetField(tiff, TIFFTAG_TILELENGTH, kTile);
    for (int top = 0; top < height; top += kTile) {
      for (int left = 0; left < width; left += kTile) {
        row.clear();
        for (int y = top; y < top + kTile; ++y) {
          for (int x = left; x < left + kTile; ++x) {
            const Pixel p = paint(x, y);
            for (std::size_t k = 0; k < n; ++k) put_sample(row, p[k], kind.bits);
          }
        }
        TIFFWriteTile(tiff, row.data(), static_cast<std::uint32_t>(left),
                      static_cast<std::uint32_t>(top), 0, 0);
      }
    }
  } else {
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 7);
    const std::size_t planes = kind.planar ? n : 1;
    for (std::size_t plane = 0; plane < planes; ++plane) {
      for (int y = 0; y < height; ++y) {
        row.clear();
        for (int x = 0; x < width; ++x) {
          const Pixel p = paint(x, y);
          for (std::size_t k = 0; k < n; ++k) {
            if (!kind.planar || k == plane) put_sample(row, p[k], kind.bits);
          }
        }
        TIFFWriteScanline(tiff, row.data(), static_cast<std::uint32_t>(y),
                          static_cast<std::uint16_t>(plane));
      }
    }
  }
  TIFFClose(tiff);
}

}  // namespace reseau::compare
