// How sharp this very scan is, read off the réseau: its pattern is known, so the ratio of measured
// to ideal harmonics is the MTF at the lattice frequencies.
#pragma once

#include <array>
#include <stop_token>

#include "core/geometry/vec2.h"
#include "core/line/line_source.h"
#include "core/reconstruct/reconstruct.h"

namespace reseau {

struct Sharpness {
  SharpnessReport report;
  // Where the infrared picture lies relative to RGB [px]: a detail at p in RGB is at p + shift in
  // infrared. Zero where it could not be measured.
  Vec2 infrared_shift_px;
  // Refined with the measured blur; per unit silver, [element][channel].
  std::array<std::array<double, 3>, 3> response{};
  std::array<double, 3> silver_from_rgb{};
};

// Looks at up to some 200 tiles of the frame, whatever its size. R, G, B: the series of RGB over
// silver, tiles with even silver counting most. Infrared: its modulation where the picture is
// coloured, against that of the silver computed from RGB at the same place. What cannot be measured
// is pooled from the other channels, else a stated default (0.7 px), and the report says so.
[[nodiscard]] Sharpness measure_sharpness(const LineSource& source,
                                          const Registration& registration, const ToneCurves& tone,
                                          const std::stop_token& stop);

}  // namespace reseau
