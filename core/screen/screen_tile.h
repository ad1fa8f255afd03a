// What one tile of the picture says about the réseau in each channel: amplitudes of its harmonics
// in raw linear light. Never ratios of channels: dividing does not commute with blur.
#pragma once

#include <array>
#include <complex>
#include <optional>

#include "core/geometry/vec2.h"
#include "core/screen/cell_moments.h"
#include "core/screen/linear_rows.h"
#include "core/screen/screen_map.h"

namespace reseau {

inline constexpr std::array<HarmonicIndex, 6> kTileHarmonics{
    {{1, 0}, {0, 1}, {1, 1}, {1, -1}, {2, 0}, {0, 2}}};
inline constexpr int kTileAmplitudes = 1 + static_cast<int>(kTileHarmonics.size());

struct ScreenTile {
  bool used = false;  // bright enough, not clipped
  // Per channel R G B S: the mean, then the even amplitudes of kTileHarmonics.
  std::array<std::array<double, kTileAmplitudes>, 4> amplitude{};
  // The odd ones of the same: the pattern has none, so they are noise and picture detail.
  std::array<std::array<double, kTileAmplitudes>, 4> odd{};
  std::array<double, 4> variance{};  // of a pixel about the fit: noise and picture detail
  double n_effective = 0;            // pixels, weighed by the window
  // Of S, all pixels alike, whether used or not: the mean, and the deviation that differences of
  // neighbours show.
  double plain_mean = 0, plain_noise = 0;
  // Complex coefficients at u and v, for shifts between channels.
  std::array<std::array<std::complex<double>, 2>, 4> fundamental{};
};

// Least squares of 1, x, y and the harmonics in a Hann-windowed tile; S is plane 3 of the rows.
[[nodiscard]] ScreenTile measure_screen_tile(const LinearRows& rows, int x0, int size,
                                             const ScreenMap& map);

// Enough of them to tell shapes of elements apart whatever the blur.
inline constexpr std::array<HarmonicIndex, 14> kShapeHarmonics{{{1, 0},
                                                                {0, 1},
                                                                {1, 1},
                                                                {1, -1},
                                                                {2, 0},
                                                                {0, 2},
                                                                {2, 1},
                                                                {2, -1},
                                                                {1, 2},
                                                                {1, -2},
                                                                {2, 2},
                                                                {2, -2},
                                                                {3, 0},
                                                                {0, 3}}};
struct ShapeTile {
  // Per channel R G B: the mean, then the even amplitudes of kShapeHarmonics; 0 for those that are
  // not sampled.
  std::array<std::array<double, 1 + kShapeHarmonics.size()>, 3> amplitude{};
};
// The same least squares. Empty where a tile is dark or lost.
[[nodiscard]] std::optional<ShapeTile> measure_shape_tile(const LinearRows& rows, int x0, int size,
                                                          const ScreenMap& map);

// Whether the pixels hold a harmonic. frequency: the transposed Jacobian of the map.
[[nodiscard]] bool is_sampled(const Mat2& frequency, HarmonicIndex harmonic);

}  // namespace reseau
