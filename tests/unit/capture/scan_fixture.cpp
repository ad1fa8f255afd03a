#include "tests/unit/capture/scan_fixture.h"

#include <cstdarg>
#include <cstdio>

#include <tiffio.h>

namespace reseau::test {
namespace {

int complain(TIFF* /*tiff*/, void* user, const char* /*module*/, const char* format,
             va_list arguments) {
  char text[500];
  std::vsnprintf(text, sizeof text, format, arguments);
  static_cast<std::vector<std::string>*>(user)->emplace_back(text);
  return 1;
}

bool line_is_right(const std::vector<std::uint16_t>& row, const LineFormat& format, int y) {
  for (int x = 0; x < format.width_px; ++x) {
    for (int c = 0; c < format.n_channels(); ++c) {
      const auto index = static_cast<std::size_t>(x * format.n_channels() + c);
      if (row[index] != sample_at(y, c, x)) return false;
    }
  }
  return true;
}

}  // namespace

TiffCheck check_tiff(const std::filesystem::path& path, const LineFormat& format) {
  TiffCheck check;
  TIFFOpenOptions* options = TIFFOpenOptionsAlloc();
  TIFFOpenOptionsSetErrorHandlerExtR(options, complain, &check.complaints);
  TIFFOpenOptionsSetWarningHandlerExtR(options, complain, &check.complaints);
  TIFF* tiff = TIFFOpenExt(path.c_str(), "r", options);
  TIFFOpenOptionsFree(options);
  if (tiff == nullptr) return check;
  std::uint32_t width = 0, length = 0;
  std::uint16_t samples = 0;
  TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &width);
  TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &length);
  TIFFGetField(tiff, TIFFTAG_SAMPLESPERPIXEL, &samples);
  check.claimed = static_cast<int>(length);
  check.samples = samples;
  std::vector<std::uint16_t> row(format.samples_per_line());
  if (width == static_cast<std::uint32_t>(format.width_px) && samples == format.channels.size()) {
    for (std::uint32_t y = 0; y < length; ++y) {
      if (TIFFReadScanline(tiff, row.data(), y, 0) != 1) break;
      if (!line_is_right(row, format, static_cast<int>(y))) break;
      ++check.right;
    }
  }
  TIFFClose(tiff);
  return check;
}

}  // namespace reseau::test
