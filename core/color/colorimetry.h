// CIE colorimetry: observers, illuminants, spectrum to XYZ, chromaticities. XYZ is always scaled so
// that the bare light has Y = 1. Pure functions, reentrant; tables in core/color/data.
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "core/color/matrix3.h"
#include "core/color/spectrum.h"

namespace reseau {

using Xyz = Vector3;
using Chromaticity = std::array<double, 2>;  // CIE 1931 x, y

// CIE 1931 2 degree observer.
struct Observer {
  WavelengthGrid grid;
  std::vector<double> xbar, ybar, zbar;
};
// The grid on which every figure of the project is computed: 380..780 nm in steps of 5.
[[nodiscard]] const Observer& observer_5nm();
// 360..830 nm in steps of 1, to see what the coarser grid costs.
[[nodiscard]] const Observer& observer_1nm();

enum class Illuminant { kA, kB, kC, kD50, kD65, kE };

// "A", "B", "C", "D50", "D65" or "E"; InputError for anything else, listing these.
[[nodiscard]] Illuminant parse_illuminant(std::string_view name);
// Relative spectral power, 100 at 560 nm, 380..780 nm in steps of 5.
[[nodiscard]] const Spectrum& illuminant_spectrum(Illuminant illuminant);

// Daylight of a correlated colour temperature by the CIE method (mean daylight and two components,
// factors rounded to three decimals), 380..780 nm in steps of 5. 4000..25000 K, else InputError.
// D50 and D65 are defined at 1.4388/1.4380 times their nominal 5000 and 6500 K.
[[nodiscard]] Spectrum daylight_spectrum(double temperature_k);

// Plain sums over the observer's grid of transmittance x light; both spectra must already be on
// that grid (CHECK).
[[nodiscard]] Xyz xyz_from_transmittance(const Spectrum& transmittance, const Spectrum& light,
                                         const Observer& observer);

// The light itself, Y = 1. The Illuminant overload uses the 5 nm observer.
[[nodiscard]] Xyz white_of(const Spectrum& light, const Observer& observer);
[[nodiscard]] Xyz white_of(Illuminant illuminant);

// x = y = 0 for black.
[[nodiscard]] Chromaticity chromaticity_of(const Xyz& xyz);
// y must be positive, everything finite, else InputError.
[[nodiscard]] Xyz xyz_from_chromaticity(const Chromaticity& xy, double luminance);

}  // namespace reseau
