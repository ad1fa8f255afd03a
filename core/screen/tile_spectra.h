// Colour spectra of tiles of a scan and their peaks: where a search for a réseau begins. Include
// from .cpp files of this folder only.
#pragma once

#include <complex>
#include <cstddef>
#include <vector>

#include "core/geometry/vec2.h"
#include "core/screen/linear_rows.h"

namespace reseau {

// A peak sums 5 x 5 bins of two spectra, 72 on average where there is only noise.
inline constexpr double kNoisePower = 110;

struct SearchTile {
  int x = 0, y = 0;
  double light = 0;
};

// Power of the two colour signals of a tile: red against the others, green against blue. Both are
// ratios to the silver, so that the picture itself drops out.
struct Spectra {
  int size = 0;
  std::vector<float> red;         // |F(R' - (G' + B') / 2)|^2, [ky][kx]
  std::vector<float> green_blue;  // |F(G' - B')|^2

  [[nodiscard]] float at(const std::vector<float>& power, int kx, int ky) const {
    const int mask = size - 1;
    return power[static_cast<std::size_t>(ky & mask) * static_cast<std::size_t>(size) +
                 static_cast<std::size_t>(kx & mask)];
  }
};

struct SpectralPeak {
  Vec2 frequency;
  double red = 0, green_blue = 0;
  [[nodiscard]] double power() const { return red + green_blue; }
};

// Bright ones first, but spread over the rows.
[[nodiscard]] std::vector<SearchTile> choose_tiles(const LinearRows& rows, int size,
                                                   int most_tiles);
// Each signal in units of its own noise floor; size 0 where the tile is dark.
[[nodiscard]] Spectra spectra_of(const LinearRows& rows, const SearchTile& tile, int size);
// The sum over tiles, none of which outweighs the rest.
[[nodiscard]] Spectra total_of(const std::vector<Spectra>& tiles, int size);
// Local maxima of the sum of both signals in the upper half-plane, strongest first.
[[nodiscard]] std::vector<SpectralPeak> find_peaks(const Spectra& spectra, std::size_t n_peaks,
                                                   double lowest_frequency);
// Frequency of a line near f in the spectrum of one tile, to a small part of a bin.
[[nodiscard]] Vec2 local_frequency(const Spectra& spectra, Vec2 f);

}  // namespace reseau
