#include "core/screen/line_hypothesis.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <vector>

#include <Eigen/Dense>

#include "core/screen/hypothesis_tiles.h"
#include "core/screen/screen_layout.h"

namespace reseau {
namespace {

using Wave = std::complex<double>;
// Places of harmonics 1 and 2 of v among kTileHarmonics.
constexpr std::size_t kFirst = 1, kSecond = 5;
static_assert(kTileHarmonics[kFirst].v == 1 && kTileHarmonics[kSecond].v == 2 &&
              kTileHarmonics[kFirst].u == 0 && kTileHarmonics[kSecond].u == 0);
constexpr std::array<double, 4> kLineSigmas{0.45, 0.8, 1.3, 2.0};
// By how much of its light each line must lead in its own colour: a grating of one colour has none.
constexpr double kLeastLead = 0.02;

// Mean, then the real and imaginary parts of both harmonics times sqrt(2).
using LineAmplitudes = Eigen::Matrix<double, 5, 1>;
using LineColumns = Eigen::Matrix<double, 5, 3>;

double transfer_of(double sigma_px, double frequency) {
  return std::exp(-2 * std::pow(std::numbers::pi * sigma_px * frequency, 2));
}

LineColumns line_columns(double sigma_px, double frequency) {
  LineColumns columns;
  for (int site = 0; site < 3; ++site) {
    columns(0, site) = line_harmonic(site, 0).real();
    for (int h = 1; h <= 2; ++h) {
      const Wave a =
          std::numbers::sqrt2 * transfer_of(sigma_px, h * frequency) * line_harmonic(site, h);
      columns(2 * h - 1, site) = a.real();
      columns(2 * h, site) = a.imag();
    }
  }
  return columns;
}

// Where the origin lies that the tile's channels agree on.
double origin_of(const TileView& view) {
  std::array<Wave, 3> first, second;
  for (std::size_t c = 0; c < 3; ++c) {
    const double weight = 1 / std::max(view.total[c], 1e-30);
    first[c] = weight * view.harmonic[c][kFirst];
    second[c] = view.harmonic[c][kSecond];
  }
  return line_origin(first, second);
}

LineAmplitudes turned_to(const TileView& view, std::size_t channel, double v) {
  LineAmplitudes y;
  y(0) = view.mean[channel];
  for (int h = 1; h <= 2; ++h) {
    const Wave a = std::numbers::sqrt2 * view.harmonic[channel][h == 1 ? kFirst : kSecond] *
                   std::polar(1.0, -2 * std::numbers::pi * h * v);
    y(2 * h - 1) = a.real();
    y(2 * h) = a.imag();
  }
  return y;
}

// How the sites of a period may be coloured: red, green and blue in the direction of v, or against
// it, beginning anywhere.
struct Order {
  bool forward = true;
  int start = 0;
  [[nodiscard]] int color(int site) const {
    return (forward ? site + start : start - site + 3) % 3;
  }
  // True v of what lies at v under the order so far.
  [[nodiscard]] double v(double before) const {
    return forward ? before + start / 3.0 : (start + 1) / 3.0 - before;
  }
};

struct LineTile {
  double v = 0;  // of the corner, so far
  std::array<Eigen::Vector4d, 3> lights;
  double explained = 0;
};

// The start that suits the colours of a tile best, and how much more each site shows its own colour
// than a third.
Order best_order(const LineTile& tile, const Cast& cast, bool forward, double& lead) {
  Order best{forward, 0};
  lead = -1e30;
  for (int start = 0; start < 3; ++start) {
    const Order order{forward, start};
    double sum = 0;
    for (int site = 0; site < 3; ++site) {
      const Eigen::Vector3d y = tile.lights[static_cast<std::size_t>(site)]
                                    .head<3>()
                                    .cwiseProduct(cast.inverse_mean)
                                    .cwiseMax(0);
      sum += y(order.color(site)) / std::max(y.sum(), 1e-12) - 1.0 / 3;
    }
    if (sum > lead) {
      lead = sum;
      best = order;
    }
  }
  return best;
}

}  // namespace

Carriers carriers_of_lines(Vec2 frequency) {
  return {{frequency.y, -frequency.x}, frequency, true};
}

LatticeHypothesis judge_lines(const LinearRows& rows, const std::vector<TileCorner>& corners,
                              const std::vector<Vec2>& tile_frequencies, int tile_size,
                              bool infrared) {
  LatticeHypothesis best;
  best.layout = ScreenLayout::kLines;
  std::vector<Carriers> carriers;
  carriers.reserve(tile_frequencies.size());
  for (const Vec2 f : tile_frequencies) carriers.push_back(carriers_of_lines(f));
  const std::vector<TileEntry> entries = measure_entries(rows, corners, carriers, tile_size);
  if (entries.empty()) return best;
  const Cast cast = cast_of(entries);
  const std::size_t n_channels = infrared ? 4 : 3;
  std::vector<LineTile> tiles;
  for (const double sigma : kLineSigmas) {
    const LineColumns columns = line_columns(sigma, norm(tile_frequencies[entries[0].tile]));
    const Eigen::HouseholderQR<LineColumns> qr(columns);
    const LineColumns span = qr.householderQ() * LineColumns::Identity();
    std::vector<LineTile> now;
    double sum = 0;
    for (const TileEntry& entry : entries) {
      LineTile tile;
      tile.v = origin_of(entry.view);
      for (std::size_t c = 0; c < 4; ++c) {
        const LineAmplitudes y = turned_to(entry.view, c, tile.v);
        const Eigen::Vector3d lights = qr.solve(y);
        for (std::size_t k = 0; k < 3; ++k)
          tile.lights[k](static_cast<Eigen::Index>(c)) = lights(static_cast<Eigen::Index>(k));
        if (c < n_channels) {
          tile.explained += ((span.transpose() * y).squaredNorm() - y(0) * y(0)) /
                            std::max(entry.view.total[c], 1e-30) / static_cast<double>(n_channels);
        }
      }
      sum += tile.explained;
      now.push_back(tile);
    }
    const double explained = sum / static_cast<double>(entries.size());
    if (!(explained > best.explained)) continue;
    best.explained = explained;
    best.sigma_px = sigma;
    tiles = std::move(now);
  }
  if (tiles.empty()) return best;
  // In which direction the colours follow one another, all tiles together say.
  double total[2] = {0, 0};
  for (const LineTile& tile : tiles) {
    for (const bool forward : {true, false}) {
      double lead = 0;
      static_cast<void>(best_order(tile, cast, forward, lead));
      total[forward ? 0 : 1] += std::max(tile.explained, 0.0) * lead;
    }
  }
  const bool forward = total[0] >= total[1];
  std::array<std::vector<Eigen::Vector4d>, 3> lights;
  std::size_t seed = 0;
  double seed_v = 0, weights = 0;
  Vec2 mean;
  for (std::size_t e = 0; e < tiles.size(); ++e) {
    double lead = 0;
    const Order order = best_order(tiles[e], cast, forward, lead);
    const double weight = std::max(tiles[e].explained, 0.0);
    for (int site = 0; site < 3; ++site)
      lights[static_cast<std::size_t>(order.color(site))].push_back(
          weight * tiles[e].lights[static_cast<std::size_t>(site)]);
    const Vec2 f = tile_frequencies[entries[e].tile];
    mean = mean + weight * weight * f;
    weights += weight * weight;
    if (e == 0 || tiles[e].explained > tiles[seed].explained) {
      seed = e;
      seed_v = order.v(tiles[e].v);
    }
  }
  std::array<Eigen::Vector3d, 3> response;
  for (std::size_t k = 0; k < 3; ++k) {
    response[k] = element_response(lights[k], infrared);
    for (std::size_t c = 0; c < 3; ++c)
      best.response[k][c] = response[k](static_cast<Eigen::Index>(c));
  }
  best.colors_fit = cast.margin(response, {0, 1, 2}) > kLeastLead;
  const double sign = forward ? 1 : -1;
  const std::size_t at = entries[seed].tile;
  best.carriers = carriers_of_lines(sign * tile_frequencies[at]);
  best.mean_carriers = carriers_of_lines((sign / std::max(weights, 1e-30)) * mean);
  const double mid = (tile_size - 1) / 2.0;
  best.center_px = {corners[at].x + mid, corners[at].y + mid};
  // u begins at the first pixel of these rows.
  best.screen_at_center = {dot(best.carriers.u, best.center_px),
                           seed_v + dot(best.carriers.v, {mid, mid})};
  return best;
}

double settle_lines(ColorSeries& series, double period_px) {
  std::array<Wave, 3> first, second;
  double cross = 0, square = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    first[c] = series.harmonic[c][1];
    second[c] = series.harmonic[c][0];
    cross += std::abs(first[c]) * std::abs(second[c]);
    square += std::norm(first[c]);
  }
  const double v = line_origin(first, second);
  for (auto& channel : series.harmonic) {
    channel[0] *= std::polar(1.0, -4 * std::numbers::pi * v);
    channel[1] *= std::polar(1.0, -2 * std::numbers::pi * v);
    channel[2] = channel[3] = 0;
  }
  // Of sharp lines the second is half of the first; blur takes exp(-6 pi^2 sigma^2 / period^2).
  constexpr double kLeastBlur = 0.06, kMostBlur = 9;
  const double ratio = cross > 0 ? cross / square : 0.5;
  const double sigma2 = -std::log(std::max(2 * ratio, 1e-6)) * period_px * period_px /
                        (6 * std::numbers::pi * std::numbers::pi);
  return std::clamp(sigma2, kLeastBlur, kMostBlur);
}

}  // namespace reseau
