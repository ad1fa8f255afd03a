// What tiles of a scan show at the harmonics of a candidate, and what colours the lights behind its
// elements have: common to all hypotheses. Include from .cpp files of this folder only (Eigen).
#pragma once

#include <algorithm>
#include <array>
#include <complex>
#include <cstddef>
#include <vector>

#include <Eigen/Dense>

#include "core/screen/lattice_hypothesis.h"
#include "core/screen/screen_tile.h"

namespace reseau {

// Complex coefficients of kTileHarmonics, one channel.
using TileCoefficients = std::array<std::complex<double>, kTileAmplitudes - 1>;

struct TileView {
  std::array<double, 4> mean{};
  std::array<TileCoefficients, 4> harmonic;
  std::array<double, 4> total{};  // alternating energy: harmonics and the rest
};

struct TileEntry {
  TileView view;
  std::size_t tile;
};

// Those tiles that have light. Phases refer to a tile's corner.
[[nodiscard]] std::vector<TileEntry> measure_entries(const LinearRows& rows,
                                                     const std::vector<TileCorner>& corners,
                                                     const std::vector<Carriers>& tile_carriers,
                                                     int tile_size);

// Response of each element from its lights in all tiles: regressed on the lights in infrared, or
// their principal direction with the size of the brightest.
[[nodiscard]] Eigen::Vector3d element_response(const std::vector<Eigen::Vector4d>& lights,
                                               bool infrared);

// Of grey tiles: the mean, weighed by the second channel, which is 1 but for that.
[[nodiscard]] Eigen::Vector3d mean_light(const std::vector<Eigen::Vector4d>& lights);

// Colour of a light relative to the mean of each channel over all tiles, so that neither exposure
// nor a cast decides.
struct Cast {
  Eigen::Vector3d inverse_mean;

  // How much more of one colour than of another a light shows.
  [[nodiscard]] double leaning(const Eigen::Vector3d& x, int to, int from) const {
    return x(to) * inverse_mean(to) - x(from) * inverse_mean(from);
  }
  // How far, in shares of its light, each site has the most of its own colour; negative when one of
  // them has not. `color` of each site.
  [[nodiscard]] double margin(const std::array<Eigen::Vector3d, 3>& sites,
                              const std::array<int, 3>& color) const {
    const auto share = [&](std::size_t site, int of) {
      const Eigen::Vector3d y = sites[site].cwiseProduct(inverse_mean).cwiseMax(0);
      return y(of) / std::max(y.sum(), 1e-12);
    };
    double least = 1;
    for (std::size_t site = 0; site < 3; ++site) {
      for (std::size_t other = 0; other < 3; ++other) {
        if (other != site)
          least = std::min(least, share(site, color[site]) - share(other, color[site]));
      }
    }
    return least;
  }
};
[[nodiscard]] Cast cast_of(const std::vector<TileEntry>& entries);

}  // namespace reseau
