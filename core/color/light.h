// The light behind the film. Pure functions, reentrant.
#pragma once

#include <string>
#include <string_view>

#include "core/color/colorimetry.h"

namespace reseau {

struct Light {
  std::string name;
  Spectrum spectrum;  // relative power, on the grid where it is tabulated or computed
};

// Sums over 380..780 nm.
enum class SummationStep { k5nm, k1nm };
[[nodiscard]] const Observer& observer_of(SummationStep step);
// "5" or "1"; InputError otherwise.
[[nodiscard]] SummationStep parse_summation_step(std::string_view word);

[[nodiscard]] Light light_of(Illuminant illuminant);
// Daylight of 4000..25000 K (CIE 15:2018, 3.1).
[[nodiscard]] Light daylight(double temperature_k);
// Black body of 1000..25000 K (Planck's law, c2 = 1.4388e-2 m K), 100 at 560 nm. InputError beyond.
[[nodiscard]] Light planckian(double temperature_k);
// "A" "B" "C" "D50" "D65" "E"; "D55" and other nominal daylights; a temperature, "3200K" or
// "5500K": a black body below 4000 K, daylight from there; "planck:2856", "daylight:5500".
// InputError else.
[[nodiscard]] Light parse_light(std::string_view word);

// Its power on the observer's grid (linear between the tabulated wavelengths), and its white, Y
// = 1.
[[nodiscard]] Spectrum power_on(const Light& light, const WavelengthGrid& grid);
[[nodiscard]] Xyz white_of(const Light& light, SummationStep step);

}  // namespace reseau
