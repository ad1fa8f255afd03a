// Finds a réseau without any prior: two lattice frequencies, how the elements lie, which is which,
// and the phase at one place, from the spectra of a few tiles.
#pragma once

#include <string>

#include "core/screen/cell_moments.h"
#include "core/screen/lattice_hypothesis.h"
#include "core/screen/linear_rows.h"
#include "core/screen/window_fit.h"

namespace reseau {

inline constexpr int kLargestTilePx = 256, kSmallestTilePx = 64;

struct LatticeSeed {
  ScreenLayout layout = ScreenLayout::kLinesAndSquares;
  int special_color = 0;
  bool grey = false;                          // no colours: which element is which is not known
  double explained = 0, other_explained = 0;  // as in LatticeHypothesis
  Carriers carriers;                          // right-handed: cross(u, v) > 0; mean of the tiles
  Vec2 center_px;                             // of the tile that shows the pattern best
  Vec2 screen_at_center;                      // screen coordinates there
  Carriers at_center;                         // their slopes there
  Response response{};    // without infrared: the brightest light counts as clear
  double sigma_px = 0.7;  // a rough blur
  double confidence = 0;  // 0..1
  // Power of the strongest peak that is no harmonic of this lattice over the lattice's own: more
  // than one where something else repeats more plainly, as the inks of a halftone.
  double foreign = 0;
};

struct LatticeSearch {
  bool found = false;
  bool dark = false;   // no tile had light
  std::string reason;  // why not, a sentence
  LatticeSeed seed;
};

// Looks for periods from about 2.6 to 20 px at any angle in a block of rows (whole frames too: only
// some tiles are looked at). Deterministic. The block should have at least 64 x 64 px.
// `infrared`: plane 3 of the rows is infrared, not made of RGB. largest_tile_px: a power of two
// from 64; small tiles find film that bends within large ones.
// most_tiles: of that size that are looked at.
inline constexpr int kMostTiles = 20, kFewTiles = 6;
[[nodiscard]] LatticeSearch find_lattice(const LinearRows& rows, bool infrared,
                                         int largest_tile_px = kLargestTilePx,
                                         int most_tiles = kMostTiles);

// The colour series that a réseau with this response shows under a Gaussian blur of sigma_px
// (isotropic) and the given carriers. The response is by colour.
[[nodiscard]] ColorSeries series_from_response(const Response& response, ScreenLayout layout,
                                               int special_color, const Carriers& carriers,
                                               double sigma_px);
// Weights w with w . response[k] = 1 for the three elements: linear RGB to silver (Barker et al.
// 2022). False when the response is too close to singular.
[[nodiscard]] bool silver_weights(const Response& response, std::array<double, 3>& weights);

}  // namespace reseau
