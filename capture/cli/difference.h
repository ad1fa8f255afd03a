#pragma once

#include <filesystem>
#include <stop_token>
#include <string>

namespace reseau::cli {

struct DifferenceFigures {
  double mean = 0, median = 0, p95 = 0, max = 0;
};

// Colour difference of two pictures, pixel by pixel.
struct Difference {
  int width_px = 0, height_px = 0;
  long long n_pixels = 0;      // that counted
  long long n_not_finite = 0;  // left out: NaN or infinity in one of the two
  DifferenceFigures all;
  DifferenceFigures without_worst_percent;
  double max_abs = 0;  // largest difference of any sample, as the files hold them
  bool identical = false;
};

// CIEDE2000 between two EXR files of the same size, each brought to XYZ by its own chromaticities
// (those of sRGB when it has none), CIELAB against D65. Throws InputError, std::system_error. Stops
// early, with what was counted so far, on a stop request.
[[nodiscard]] Difference compare_pictures(const std::filesystem::path& a,
                                          const std::filesystem::path& b,
                                          const std::stop_token& stop);

}  // namespace reseau::cli
