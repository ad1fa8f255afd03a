// The silver without infrared: behind a filter the scanner sees t p_k + dark, t the transmittance
// of the silver (which is neutral) and p_k its response to the clear element k. Weights w with
// w . p_k equal for the three elements make t of red, green and blue wherever the pixel lies, up to
// a balance of the elements (Barker et al. 2022, arXiv:2211.16076). Pure, reentrant.
#pragma once

#include <array>
#include <optional>
#include <stop_token>

#include "core/line/line_source.h"
#include "core/reconstruct/tone_curve.h"

namespace reseau {

// silver = offset + weights . (red, green, blue), all linear, 1 = full scale.
struct SilverWeights {
  std::array<double, 3> weights{};
  double offset = 0;
};

struct LearnedSilver {
  SilverWeights silver;
  double correlation = 0;   // of what the weights make with the infrared
  double rms_relative = 0;  // rms of the difference over the mean of infrared
  std::size_t n_pixels = 0;
};

// Weights that come nearest to the infrared of a scan that has it, for scans of the same scanner
// and film that have none: least squares over at most some 250,000 pixels on an even grid, each
// with the weight 1/infrared, clipped ones left out. All lines must be committed. Nothing for a
// scan without infrared, a stop request, or colours too alike to tell the channels apart.
[[nodiscard]] std::optional<LearnedSilver> learn_silver_from_rgb(const LineSource& source,
                                                                 const ToneCurves& tone,
                                                                 const std::stop_token& stop);

}  // namespace reseau
