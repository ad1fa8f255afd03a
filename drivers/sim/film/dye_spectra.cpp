#include "drivers/sim/film/dye_spectra.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace reseau::sim {
namespace {

// Percent at 400, 410 … 700 nm. Read from printed charts by the Color-Screen project (J. Hubicka);
// here interpolated linearly to the grid. Order of DyeSource.
constexpr std::size_t kSources = 6;
using Percent = std::array<std::array<float, kSpectrumSize>, 3>;
constexpr std::array<Percent, kSources> kPercent{{
    // Harrison and Horner, Photographic Journal 79 (1939), p. 325.
    {{
        {{0.0F,  0.0F,  0.0F,  0.0F,  0.0F,  0.0F,  0.1F,  0.9F,  1.9F,  1.1F,  0.4F,
          0.0F,  0.0F,  0.0F,  0.0F,  0.0F,  0.8F,  5.6F,  25.1F, 49.9F, 64.4F, 70.7F,
          74.1F, 76.2F, 77.4F, 78.2F, 78.7F, 79.2F, 79.6F, 80.0F, 80.7F}},
        {{2.9F,  1.6F,  0.2F,  0.0F,  0.0F,  0.0F,  2.0F,  7.8F,  26.1F, 51.7F, 69.4F,
          73.3F, 71.9F, 67.9F, 62.4F, 55.0F, 46.4F, 36.8F, 26.5F, 17.9F, 11.7F, 7.3F,
          4.4F,  2.4F,  1.3F,  1.1F,  2.9F,  9.2F,  23.0F, 42.3F, 57.9F}},
        {{32.7F, 45.9F, 58.9F, 69.5F, 74.9F, 75.1F, 72.3F, 68.5F, 63.4F, 56.3F, 44.2F,
          27.0F, 11.9F, 4.6F,  1.7F,  0.3F,  0.0F,  0.0F,  0.0F,  0.0F,  0.0F,  0.1F,
          0.6F,  1.2F,  2.4F,  5.2F,  10.8F, 19.7F, 32.5F, 48.3F, 60.9F}},
    }},
    // Cornwell-Clyne, Colour Cinematography (1951), p. 149.
    {{
        {{0.0F,  0.0F,  0.0F,  0.0F,  0.0F,  0.0F,  0.3F,  1.3F,  1.3F,  0.7F,  0.0F,
          0.0F,  0.0F,  0.0F,  0.0F,  0.0F,  0.4F,  3.3F,  19.0F, 51.7F, 68.9F, 75.6F,
          74.5F, 71.7F, 71.8F, 73.7F, 75.3F, 76.4F, 77.1F, 77.4F, 77.5F}},
        {{0.0F,  0.0F,  0.0F,  0.0F,  0.0F,  0.0F,  0.0F,  0.0F,  2.0F,  14.6F, 38.6F,
          59.5F, 71.0F, 75.6F, 73.2F, 65.2F, 55.3F, 43.5F, 30.9F, 20.6F, 13.1F, 8.0F,
          4.6F,  2.4F,  1.2F,  0.6F,  0.2F,  0.1F,  1.2F,  3.2F,  7.1F}},
        {{83.2F, 83.2F, 83.0F, 82.5F, 81.2F, 78.8F, 74.9F, 68.7F, 59.8F, 49.4F, 37.4F,
          24.3F, 12.7F, 5.1F,  1.7F,  0.2F,  0.0F,  0.0F,  0.0F,  0.0F,  0.0F,  0.0F,
          0.1F,  0.5F,  1.3F,  2.8F,  6.3F,  14.5F, 29.5F, 51.1F, 70.1F}},
    }},
    // Collins and Giles, J. Soc. Dyers Colourists 68 (1952), p. 435.
    {{
        {{0.2F,  0.1F,  0.0F,  0.1F,  3.2F,  4.8F,  4.7F,  3.9F,  2.2F,  0.1F,  0.0F,
          0.0F,  0.0F,  0.0F,  0.0F,  0.7F,  5.0F,  28.8F, 58.7F, 77.3F, 83.0F, 84.1F,
          83.7F, 82.5F, 82.0F, 82.0F, 83.1F, 84.7F, 86.6F, 88.2F, 88.5F}},
        {{7.8F,  3.9F,  0.1F,  0.1F,  0.1F,  1.5F,  5.1F,  10.1F, 21.5F, 56.2F, 80.1F,
          83.9F, 85.2F, 84.3F, 80.4F, 69.9F, 50.7F, 34.8F, 22.8F, 14.1F, 9.4F,  5.9F,
          3.1F,  0.3F,  0.1F,  0.0F,  5.6F,  13.3F, 23.4F, 36.4F, 48.7F}},
        {{86.5F, 86.4F, 85.7F, 84.2F, 82.2F, 79.6F, 76.4F, 72.6F, 68.4F, 61.4F, 46.6F,
          24.0F, 11.3F, 2.3F,  0.0F,  0.0F,  0.0F,  0.0F,  0.1F,  0.1F,  0.0F,  0.0F,
          0.0F,  0.0F,  0.0F,  1.0F,  11.3F, 21.7F, 34.0F, 42.2F, 44.2F}},
    }},
    // Neblette, Photography, its Materials and Processes (1952), p. 446.
    {{
        {{0.1F,  0.1F,  0.1F,  0.1F,  0.1F,  0.1F,  0.1F,  0.1F,  0.1F, 0.1F,  0.2F,
          0.2F,  0.2F,  0.2F,  0.2F,  0.1F,  0.1F,  0.2F,  1.6F,  7.2F, 19.8F, 39.4F,
          66.9F, 80.2F, 82.5F, 83.8F, 84.7F, 85.3F, 85.9F, 86.3F, 86.4F}},
        {{0.1F,  0.1F,  0.1F,  0.1F,  0.1F,  0.1F,  0.1F,  0.2F,  1.8F,  6.5F,  13.1F,
          23.3F, 44.2F, 64.8F, 69.0F, 68.3F, 63.7F, 51.7F, 34.3F, 22.7F, 12.5F, 6.0F,
          1.9F,  0.1F,  0.1F,  0.1F,  0.1F,  0.1F,  0.2F,  0.2F,  0.1F}},
        {{52.0F, 55.2F, 57.7F, 59.6F, 60.9F, 61.6F, 60.9F, 56.8F, 49.1F, 31.8F, 14.6F,
          5.9F,  1.6F,  0.1F,  0.1F,  0.1F,  0.1F,  0.1F,  0.1F,  0.2F,  0.2F,  0.2F,
          0.2F,  0.2F,  0.2F,  0.1F,  0.1F,  0.1F,  0.2F,  0.2F,  0.1F}},
    }},
    // Thames plate: Mees and Pledge, Photographic Journal 50 (1910), pp. 197-221; densities above
    // 1.5 read as 1.5.
    {{
        {{3.2F,  3.9F,  4.9F,  6.0F,  7.5F,  9.6F,  15.6F, 21.2F, 27.4F, 31.2F, 28.3F,
          21.8F, 16.1F, 10.5F, 7.8F,  7.5F,  12.0F, 32.4F, 88.7F, 92.1F, 92.6F, 93.2F,
          93.8F, 94.4F, 95.0F, 95.6F, 96.3F, 96.9F, 97.5F, 98.1F, 98.7F}},
        {{3.2F,  4.3F,  5.9F,  8.0F,  11.0F, 15.0F, 20.6F, 32.9F, 45.2F, 73.7F, 84.5F,
          89.0F, 87.3F, 80.1F, 74.4F, 70.2F, 63.9F, 53.0F, 45.0F, 38.7F, 29.9F, 26.0F,
          23.6F, 22.0F, 21.9F, 25.1F, 36.6F, 57.1F, 74.4F, 81.0F, 86.9F}},
        {{47.9F, 47.9F, 47.9F, 47.9F, 47.9F, 48.4F, 52.8F, 59.6F, 59.6F, 51.2F, 47.1F,
          42.2F, 23.7F, 14.4F, 10.1F, 7.3F,  9.1F,  14.9F, 25.3F, 30.4F, 34.7F, 28.6F,
          26.7F, 28.0F, 33.1F, 37.4F, 48.9F, 60.7F, 68.8F, 75.6F, 83.0F}},
    }},
    // Dioptichrome plate: Mees and Pledge, as above.
    {{
        {{3.2F,  3.4F,  3.6F,  3.8F,  4.0F,  4.2F,  4.5F,  5.0F,  5.4F,  5.7F,  5.9F,
          6.0F,  6.1F,  6.2F,  6.5F,  7.0F,  7.9F,  11.4F, 18.2F, 22.1F, 27.4F, 34.7F,
          70.7F, 96.5F, 97.4F, 97.7F, 98.0F, 98.3F, 98.6F, 98.9F, 99.3F}},
        {{3.2F,  3.8F,  4.5F,  5.4F,  6.5F,  7.9F,  13.0F, 23.6F, 31.0F, 43.6F, 62.5F,
          89.7F, 97.4F, 96.9F, 96.3F, 95.1F, 85.8F, 73.4F, 45.2F, 28.7F, 19.6F, 14.7F,
          9.9F,  8.0F,  7.3F,  9.3F,  14.6F, 40.2F, 55.4F, 72.8F, 95.9F}},
        {{100.0F, 96.4F, 92.6F, 89.0F, 85.5F, 82.1F, 78.9F, 75.1F, 71.3F, 68.2F, 57.0F,
          50.3F,  38.9F, 29.7F, 20.3F, 17.0F, 14.7F, 16.2F, 17.1F, 16.7F, 13.6F, 10.6F,
          13.8F,  23.9F, 38.2F, 48.2F, 50.8F, 53.6F, 56.5F, 59.5F, 62.8F}},
    }},
}};

}  // namespace

Spectrum dye_spectrum(DyeSource source, int dye, double fade) {
  const auto set = static_cast<std::size_t>(source);
  const auto& percent = kPercent[std::min(set, kSources - 1)][static_cast<std::size_t>(dye)];
  // A chart that touches zero says less than about one part in a thousand.
  constexpr double kDarkest = 1e-3;
  Spectrum result{};
  for (std::size_t i = 0; i < kSpectrumSize; ++i) {
    const double fresh = std::max(static_cast<double>(percent[i]) / 100, kDarkest);
    result[i] = std::pow(fresh, 1 - fade);
  }
  return result;
}

Spectrum band(double peak_nm, double fwhm_nm) {
  Spectrum result{};
  double sum = 0;
  for (std::size_t i = 0; i < kSpectrumSize; ++i) {
    const double x = (wavelength_nm(i) - peak_nm) / fwhm_nm;
    result[i] = std::exp(-4 * std::log(2.0) * x * x);
    sum += result[i];
  }
  for (double& v : result) v /= sum;
  return result;
}

}  // namespace reseau::sim
