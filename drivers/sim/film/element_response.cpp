#include "drivers/sim/film/element_response.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace reseau::sim {
namespace {

struct Led {
  double peak_nm, fwhm_nm;
};
// Peaks as Color-Screen gives them for Coolscans; the widths are those of common LEDs of these
// colours, not measured on a unit.
constexpr std::array<Led, 3> kLeds{{{653, 20}, {526, 35}, {466, 25}}};

Spectrum through(int set, DyeSource source, double fade) {
  Spectrum result{};
  result.fill(1.0);
  for (int dye = 0; dye < 3; ++dye) {
    if ((set >> dye & 1) == 0) continue;
    const Spectrum one = dye_spectrum(source, dye, fade);
    for (std::size_t i = 0; i < kSpectrumSize; ++i) result[i] *= one[i];
  }
  return result;
}

double inner(const Spectrum& a, const Spectrum& b) {
  double sum = 0;
  for (std::size_t i = 0; i < kSpectrumSize; ++i) sum += a[i] * b[i];
  return sum;
}

}  // namespace

ElementResponse element_response(double fade) {
  // Per unit of infrared, from a 4000 dpi LS-9000 scan with all four channels.
  constexpr ElementResponse kFresh{{{1.25, 0.16, 0.16}, {0.08, 1.01, 0.46}, {0.07, 0.21, 0.77}}};
  constexpr double kLargest = 1.25;
  ElementResponse result{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double grey = (kFresh[k][0] + kFresh[k][1] + kFresh[k][2]) / 3;
    for (std::size_t c = 0; c < 3; ++c) {
      result[k][c] = ((1 - fade) * kFresh[k][c] + fade * grey) / kLargest;
    }
  }
  return result;
}

DyeSetResponse dye_set_response(const DyeSpec& spec) {
  DyeSetResponse result{};
  const ElementResponse measured = element_response(spec.fade);
  for (std::size_t set = 0; set < kOpaque; ++set) {
    for (std::size_t c = 0; c < 3; ++c) {
      if (spec.source == DyeSource::kMeasured) {
        result[set][c] = 1;
        for (std::size_t dye = 0; dye < 3; ++dye) {
          if ((set >> dye & 1) != 0) result[set][c] *= measured[dye][c];
        }
      } else {
        result[set][c] = inner(through(static_cast<int>(set), spec.source, spec.fade),
                               band(kLeds[c].peak_nm, kLeds[c].fwhm_nm));
      }
    }
    result[set][3] = std::pow(std::max(result[set][0], 1e-6), spec.infrared_leak);
  }
  return result;  // opaque: no light of any kind
}

Taking make_taking(bool ideal) {
  constexpr DyeSource kSource = DyeSource::kHarrisonHorner;
  constexpr std::array<double, 3> kSceneBands{610, 540, 450};
  Taking taking;
  taking.is_identity = ideal;
  Spectrum even{};
  even.fill(1.0 / kSpectrumSize);
  std::array<double, 3> mean{};
  for (std::size_t k = 0; k < 3; ++k) {
    const Spectrum filter = dye_spectrum(kSource, static_cast<int>(k), 0);
    mean[k] = inner(filter, even);
    if (ideal) continue;
    double sum = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      sum += taking.matrix[k][j] = inner(filter, band(kSceneBands[j], 40));
    }
    for (double& v : taking.matrix[k]) v /= sum;
  }
  for (int set = 0; set < kOpaque; ++set) {
    double of_elements = 0;
    int n = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      if (set != 0 && (set >> k & 1) == 0) continue;
      of_elements += mean[k];
      ++n;
    }
    const double passes = inner(through(set, kSource, 0), even);
    taking.gain[static_cast<std::size_t>(set)] = passes / (of_elements / n);
  }
  return taking;
}

}  // namespace reseau::sim
