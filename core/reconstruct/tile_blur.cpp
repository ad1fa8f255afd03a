#include "core/reconstruct/tile_blur.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"

namespace reseau {
namespace {

using Amplitudes = ElementModel::Amplitudes;

struct TileBlur {
  BlurSample sample;  // sd 0 when the tile does not tell
  double misfit = 0;
};

// The blur of one channel in one tile alone.
TileBlur tile_blur(const ScreenTile& tile, std::size_t channel, const BlurTable& table,
                   double about_px) {
  const Amplitudes even = weighted_amplitudes(tile.amplitude[channel]),
                   odd = weighted_amplitudes(tile.odd[channel]);
  // What is not the pattern's shows in the odd amplitudes, and looks the same in the even ones.
  const double variance = odd.tail<kTileAmplitudes - 1>().squaredNorm() / (kTileAmplitudes - 1) +
                          tile.variance[channel] / tile.n_effective + 1e-12;
  const auto cost = [&](int i) {
    return (table.left(i).transpose() * even).squaredNorm() / variance;
  };
  constexpr double kRange = 2.5;
  const auto index = [&table](double sigma_px) {
    return std::clamp(static_cast<int>(std::lround(BlurTable::index_of(sigma_px))), 1,
                      table.size() - 2);
  };
  const int low = index(about_px / kRange), high = index(about_px * kRange);
  int at = low;
  double best = 1e300;
  for (int i = low; i <= high; ++i) {
    const double value = cost(i);
    if (value < best) best = value, at = i;
  }
  TileBlur found;
  found.misfit = best;
  const double before = cost(at - 1), after = cost(at + 1);
  const double bend = before - 2 * best + after;  // of the cost per step of the table, squared
  if (!(bend > 0)) return found;
  const double shift = std::clamp(0.5 * (before - after) / bend, -1.0, 1.0);
  const double sigma = BlurTable::sigma_px(at + shift);
  // A model that does not fit is to be trusted less.
  const double scatter = std::max(1.0, best / (kTileAmplitudes - 4));
  const double sd = std::sqrt(2 * scatter / bend) * sigma * std::log(BlurTable::kRatio);
  if (!(sd < 0.2 * about_px)) return found;
  found.sample.variance_px2 = sigma * sigma;
  // Steps of the search bound what a perfect tile can tell.
  found.sample.sd = 2 * sigma * std::hypot(sd, 0.001);
  return found;
}

}  // namespace

BlurField fit_blur_field(const MeasuredTiles& measured, const BlurTable& table,
                         const std::array<double, 4>& about_px, std::size_t n_channels,
                         Vec2 frame_px) {
  BlurField field;
  std::array<std::vector<BlurSample>, 4> samples;
  const auto n = measured.tiles.size();
  std::vector<std::array<TileBlur, 4>> found(n);
  parallel_for(static_cast<int>(n), [&](int i) {
    const auto t = static_cast<std::size_t>(i);
    if (!measured.tiles[t].used) return;
    for (std::size_t c = 0; c < n_channels; ++c) {
      found[t][c] = tile_blur(measured.tiles[t], c, table, about_px[c]);
      found[t][c].sample.at_px = measured.middles[t];
    }
  });
  constexpr double kMostMisfit = 40;
  for (const auto& tile : found) {
    for (std::size_t c = 0; c < n_channels; ++c) {
      if (tile[c].sample.sd > 0) samples[c].push_back(tile[c].sample);

      if (c < 3) field.misfit += std::min(tile[c].misfit, kMostMisfit);
    }
  }
  for (std::size_t c = 0; c < n_channels; ++c) {
    BlurSurface& surface = field.surface[c];
    surface = BlurSurface(about_px[c]);
    if (c < 3 && samples[c].size() >= 6) {
      BlurSurface own = fit_blur_surface(samples[c], frame_px, BlurSurface::kMostDegree, nullptr);
      // A constant is known better from all amplitudes together.
      if (own.degree() > 0) surface = std::move(own);
    }
  }
  if (n_channels < 4) return field;
  const BlurSurface rgb =
      BlurSurface::mixed(BlurSurface::mixed(field.surface[0], 1.0 / 3, field.surface[1], 1.0 / 3),
                         1, field.surface[2], 1.0 / 3);
  if (rgb.degree() == 0) return field;
  // Infrared that shows too little by place has the shape of RGB, and its own size.
  double of_rgb = 0;
  for (std::size_t c = 0; c < 3; ++c) of_rgb += about_px[c] * about_px[c] / 3;
  const double scale = about_px[3] * about_px[3] / of_rgb;
  field.surface[3] = samples[3].size() >= 6
                         ? fit_blur_surface(samples[3], frame_px, 2, &rgb)
                         : BlurSurface::mixed(rgb, scale, BlurSurface(about_px[3]), 0);
  return field;
}

}  // namespace reseau
