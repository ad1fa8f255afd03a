// Printed transmission curves of réseau dyes, and bands of light.
#pragma once

#include <array>
#include <cstddef>

namespace reseau::sim {

// Where the dyes' transmission comes from. kMeasured is no spectrum but the response of a scanner
// (element_response.h).
enum class DyeSource {
  kHarrisonHorner,
  kCornwellClyne,
  kCollinsGiles,
  kNeblette,
  kThames,
  kDioptichrome,
  kMeasured
};

inline constexpr std::size_t kSpectrumSize = 31;  // 400, 410 … 700 nm
using Spectrum = std::array<double, kSpectrumSize>;

[[nodiscard]] constexpr double wavelength_nm(std::size_t i) {
  return 400.0 + 10.0 * static_cast<double>(i);
}

// Transmittance of the red (0), green (1) or blue (2) dye. Fading takes away that fraction of its
// density: T^(1 - fade).
[[nodiscard]] Spectrum dye_spectrum(DyeSource source, int dye, double fade);

// Gaussian band of light of sum 1.
[[nodiscard]] Spectrum band(double peak_nm, double fwhm_nm);

}  // namespace reseau::sim
