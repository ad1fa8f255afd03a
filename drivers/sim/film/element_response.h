// What light makes of dyed elements: the scanner's red, green, blue and infrared through them, and
// the camera's light on its way to the emulsion.
#pragma once

#include <array>

#include "drivers/sim/film/dye_spectra.h"

namespace reseau::sim {

// What the scanner's red, green and blue light sees of a clear element, bare light = 1. Infrared
// passes every element unhindered. [element R G B][channel R G B].
using ElementResponse = std::array<std::array<double, 3>, 3>;

// Measured on a 4000 dpi LS-9000 scan of a Dufaycolor (per unit of infrared), scaled so that the
// largest value is 1; fade 1 makes every element grey at its own mean.
[[nodiscard]] ElementResponse element_response(double fade);

struct DyeSpec {
  DyeSource source = DyeSource::kMeasured;
  double fade = 0;           // 0 fresh .. 1: measured, grey; spectra, bleached
  double infrared_leak = 0;  // density in infrared as a fraction of the density in red light
};

// The dyes that lie over each other in a place, as bits: 1 red, 2 green, 4 blue. 0 is a clear gap,
// kOpaque a dark one.
inline constexpr int kOpaque = 8, kDyeSets = 9;

// [set][channel R G B IR]. Spectra are weighed with the bands of the LEDs; dyes over each other
// multiply wavelength by wavelength (the measured response: channel by channel).
using DyeSetResponse = std::array<std::array<double, 4>, kDyeSets>;
[[nodiscard]] DyeSetResponse dye_set_response(const DyeSpec& spec);

// What the camera's light does behind sets of dyes.
struct Taking {
  // Exposure behind element k = sum over j of matrix[k][j] * light[j]; rows sum to 1, as a
  // compensating filter in the camera makes them.
  std::array<std::array<double, 3>, 3> matrix{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  // Exposure behind set s = gain[s] * mean of the exposures of its elements (clear: of all three).
  std::array<double, kDyeSets> gain{};
  bool is_identity = true;
};
// ideal: each element passes its own third of the spectrum only. Otherwise the curves of Harrison
// and Horner 1939 for scenes of three bands of light, 40 nm wide, at 610, 540 and 450 nm.
[[nodiscard]] Taking make_taking(bool ideal);

}  // namespace reseau::sim
