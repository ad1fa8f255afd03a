// How sharp this very scan is, read off the réseau: its pattern is known, so the ratio of measured
// to ideal harmonics is the MTF at the lattice frequencies.
#pragma once

#include <array>
#include <stop_token>

#include "core/geometry/vec2.h"
#include "core/line/line_source.h"
#include "core/reconstruct/reconstruct.h"
#include "core/reconstruct/sharpness_field.h"
#include "core/screen/blur_shape.h"

namespace reseau {

struct Sharpness {
  SharpnessReport report;
  PrintedScreen printed;
  // Refined with the measured blur; per unit silver, [element][channel].
  std::array<std::array<double, 3>, 3> response{};
  std::array<double, 3> silver_from_rgb{};
  BlurShape shape;                    // of all blurs, but for light that goes far
  std::array<double, 4> far_share{};  // R G B IR
  // How the blur changes over the frame, R G B IR.
  std::array<BlurSurface, 4> field;
  // Of a pixel's silver, over the silver there: noise, grain and what no réseau explains, in the
  // calmest places of the picture.
  double noise_ratio = 0.003;
  // Of a pixel's silver where there is next to no light, over that of clear film; 0 where no tile
  // of the picture is that dark.
  double dark_noise = 0;
  // How much red beside green is found to differ from red beside blue (amplitude over the light),
  // which this model of a film does not allow; 0 where it does not stand out.
  double line_alternation = 0;
};

// Looks at up to some 200 tiles of the frame, whatever its size. The harmonics of the réseau in raw
// linear light determine one sigma per channel, infrared too (where the picture is coloured the
// silver shows the pattern), and the printed widths, together; what the picture itself adds is
// measured by the odd harmonics, which the pattern does not have, and subtracted. Weak priors (0.7
// px, infrared a little softer, the widths of the micrograph) decide only what the data leave open;
// the report says which channel was measured, pooled or left at the default. A blur that changes
// over the frame is followed tile by tile; where a tile is too dark or too busy its neighbours
// decide, and where infrared shows too little of the réseau, what it differs from RGB elsewhere. A
// profile of the unit takes the place of the default, and tells what light goes far; without one,
// 5 % where the blur is a lens's defocus, else none.
[[nodiscard]] Sharpness measure_sharpness(const LineSource& source,
                                          const Registration& registration, const ToneCurves& tone,
                                          const UnitSharpness& unit, double black_level,
                                          double light, const std::stop_token& stop);

}  // namespace reseau
