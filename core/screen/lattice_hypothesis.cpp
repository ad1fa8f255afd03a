#include "core/screen/lattice_hypothesis.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "core/screen/element_model.h"
#include "core/screen/hypothesis_tiles.h"

namespace reseau {
namespace {

using Complex = std::complex<double>;
using Coefficients = TileCoefficients;
constexpr int kPhases = 20;  // per axis, in the search for the origin of the cell
constexpr std::array<double, 4> kSigmas{0.45, 0.8, 1.3, 2.0};

// The same tile with u and v exchanged, then v reversed to stay right-handed: u' = v, v' = -u.
TileView exchanged(const TileView& view) {
  TileView out = view;
  for (std::size_t c = 0; c < 4; ++c) {
    const Coefficients& h = view.harmonic[c];
    // u' = v; v' = -u; u' + v' = v - u; u' - v' = v + u; 2u' = 2v; 2v' = -2u.
    out.harmonic[c] = {h[1], std::conj(h[0]), std::conj(h[3]), h[2], h[5], std::conj(h[4])};
  }
  return out;
}

struct Origin {
  Vec2 screen;           // of the tile's phase reference
  double explained = 0;  // energy
};

// e^(-2 pi i h . screen) of kTileHarmonics.
using Turns = std::array<Complex, kTileAmplitudes - 1>;
Turns turns_of(Vec2 screen) {
  const Complex u = std::polar(1.0, -2 * std::numbers::pi * screen.x);
  const Complex v = std::polar(1.0, -2 * std::numbers::pi * screen.y);
  static_assert(kTileHarmonics[2].u == 1 && kTileHarmonics[3].v == -1 && kTileHarmonics[5].v == 2);
  return {u, v, u * v, u * std::conj(v), u * u, v * v};
}

// Amplitudes of a channel once the cell's origin lies where the turns say: real parts, weighed.
ElementModel::Amplitudes turned(const TileView& view, std::size_t channel, const Turns& turns) {
  ElementModel::Amplitudes y;
  y(0) = view.mean[channel];
  for (std::size_t h = 0; h + 1 < kTileAmplitudes; ++h) {
    const Complex a = view.harmonic[channel][h], b = turns[h];
    y(static_cast<int>(h) + 1) = std::numbers::sqrt2 * (a.real() * b.real() - a.imag() * b.imag());
  }
  return y;
}

// Turns of the coarse grid of origins.
const std::vector<Turns>& grid_turns() {
  static const std::vector<Turns> turns = [] {
    std::vector<Turns> all;
    for (int j = 0; j < kPhases; ++j) {
      for (int i = 0; i < kPhases; ++i)
        all.push_back(
            turns_of({i / static_cast<double>(kPhases), j / static_cast<double>(kPhases)}));
    }
    return all;
  }();
  return turns;
}

class Judge {
 public:
  Judge(const ElementModel& model, double sigma, std::size_t n_channels)
      : n_channels_(n_channels), columns_(model.columns(sigma)), qr_(columns_) {
    span_ = qr_.householderQ() * ElementModel::Columns::Identity();
  }

  [[nodiscard]] Origin best_origin(const TileView& view) const {
    Origin best;
    best.explained = -1e30;
    const auto consider = [&](Vec2 screen, const Turns& turns) {
      const double value = explained(view, turns);
      if (value > best.explained) best = {screen, value};
    };
    for (int j = 0; j < kPhases; ++j) {
      for (int i = 0; i < kPhases; ++i)
        consider({i / static_cast<double>(kPhases), j / static_cast<double>(kPhases)},
                 grid_turns()[static_cast<std::size_t>(j) * kPhases + static_cast<std::size_t>(i)]);
    }
    for (double step = 0.4 / kPhases; step > 0.003; step *= 0.5) {
      const Vec2 center = best.screen;
      for (int j = -1; j <= 1; ++j) {
        for (int i = -1; i <= 1; ++i) {
          const Vec2 at = center + Vec2{i * step, j * step};
          consider(at, turns_of(at));
        }
      }
    }
    return best;
  }

  // Lights of the three sites in a channel.
  [[nodiscard]] Eigen::Vector3d lights(const TileView& view, std::size_t channel,
                                       Vec2 screen) const {
    return qr_.solve(turned(view, channel, turns_of(screen)));
  }

 private:
  // Alternating energy that three lights behind the elements explain, mean fitted too; what lies in
  // the odd parts is unexplained as well. |y|^2 - |rest|^2 = |projection on the columns|^2.
  [[nodiscard]] double explained(const TileView& view, const Turns& turns) const {
    double sum = 0;
    for (std::size_t c = 0; c < n_channels_; ++c) {
      const ElementModel::Amplitudes y = turned(view, c, turns);
      const double kept = (span_.transpose() * y).squaredNorm() - y(0) * y(0);
      sum += kept / std::max(view.total[c], 1e-30);
    }
    return sum / static_cast<double>(n_channels_);
  }

  std::size_t n_channels_;
  ElementModel::Columns columns_;
  Eigen::HouseholderQR<ElementModel::Columns> qr_;
  ElementModel::Columns span_;  // orthonormal
};

}  // namespace

LatticeHypothesis judge_lattice(const LinearRows& rows, const std::vector<TileCorner>& corners,
                                const std::vector<Carriers>& tile_carriers, int tile_size,
                                bool infrared) {
  const std::vector<TileEntry> entries = measure_entries(rows, corners, tile_carriers, tile_size);
  LatticeHypothesis best;
  if (entries.empty()) return best;
  const Cast cast = cast_of(entries);
  double best_of[2] = {0, 0};
  for (const ScreenLayout layout : {ScreenLayout::kLinesAndSquares, ScreenLayout::kTwoSites}) {
    const LayoutSites sites = layout_sites(layout);
    for (const bool exchange : {false, true}) {
      if (exchange && sites.square) continue;
      const auto carriers_of = [&](std::size_t tile) {
        const Carriers& f = tile_carriers[tile];
        return exchange ? Carriers{f.v, -1.0 * f.u} : f;
      };
      const Carriers first = carriers_of(entries[0].tile);
      const ElementModel model({first.u.x, first.u.y, first.v.x, first.v.y}, layout);
      std::vector<TileView> views;
      views.reserve(entries.size());
      for (const TileEntry& entry : entries)
        views.push_back(exchange ? exchanged(entry.view) : entry.view);
      for (const double sigma : kSigmas) {
        double sum = 0, best_tile = -1e30;
        std::vector<Origin> origins;
        std::size_t seed = 0;
        const Judge judge(model, sigma, rows.grey ? 1 : infrared ? 4 : 3);
        for (std::size_t e = 0; e < entries.size(); ++e) {
          origins.push_back(judge.best_origin(views[e]));
          sum += origins.back().explained;
          if (origins.back().explained > best_tile) {
            best_tile = origins.back().explained;
            seed = e;
          }
        }
        const double explained = sum / static_cast<double>(entries.size());
        double& best_here = best_of[static_cast<std::size_t>(layout)];
        best_here = std::max(best_here, explained);
        if (!(explained > best.explained)) continue;
        const auto lights_at = [&](std::size_t e, Vec2 screen) {
          std::array<Eigen::Vector4d, 3> x;
          for (std::size_t c = 0; c < 4; ++c) {
            const Eigen::Vector3d l = judge.lights(views[e], c, screen);
            for (std::size_t k = 0; k < 3; ++k)
              x[k](static_cast<Eigen::Index>(c)) = l(static_cast<Eigen::Index>(k));
          }
          return x;
        };
        // Which colour the special site has. Each tile may have the pair exchanged or not; its own
        // colours tell, so that all add up.
        double best_margin = -1e30;
        for (const int special : {0, 2, 1}) {
          if (layout == ScreenLayout::kTwoSites && special != 2) continue;  // none was made
          if (rows.grey && special != (layout == ScreenLayout::kTwoSites ? 2 : 0)) continue;
          const std::array<int, 3> color = site_colors(layout, special);
          const auto p = static_cast<std::size_t>(sites.pair[0]),
                     q = static_cast<std::size_t>(sites.pair[1]);
          std::array<std::vector<Eigen::Vector4d>, 3> lights;
          Vec2 seed_screen;
          for (std::size_t e = 0; e < entries.size(); ++e) {
            Vec2 screen = origins[e].screen;
            std::array<Eigen::Vector4d, 3> x = lights_at(e, screen);
            // Without colours the brighter one is called the first.
            if (rows.grey ? x[p](0) < x[q](0)
                          : cast.leaning(x[p].head<3>(), color[p], color[q]) <
                                cast.leaning(x[q].head<3>(), color[p], color[q])) {
              screen = screen + sites.pair_shift;
              x = lights_at(e, screen);
            }
            if (e == seed) seed_screen = screen;
            const double weight = std::max(origins[e].explained, 0.0);
            for (std::size_t k = 0; k < 3; ++k) lights[k].push_back(weight * x[k]);
          }
          std::array<Eigen::Vector3d, 3> response;
          for (std::size_t k = 0; k < 3; ++k)
            response[k] = rows.grey ? mean_light(lights[k]) : element_response(lights[k], infrared);
          const double margin = rows.grey ? 1 : cast.margin(response, color);
          if (!(margin > best_margin)) continue;
          best_margin = margin;
          best.special_color = special;
          best.colors_fit = margin > 0;
          const TileCorner& corner = corners[entries[seed].tile];
          const double mid = (tile_size - 1) / 2.0;
          best.carriers = carriers_of(entries[seed].tile);
          best.mean_carriers = {};
          double total = 0;
          for (std::size_t e = 0; e < entries.size(); ++e) {
            const double weight = std::pow(std::max(origins[e].explained, 0.0), 2);
            const Carriers f = carriers_of(entries[e].tile);
            best.mean_carriers.u = best.mean_carriers.u + weight * f.u;
            best.mean_carriers.v = best.mean_carriers.v + weight * f.v;
            total += weight;
          }
          best.mean_carriers = total > 0 ? Carriers{(1 / total) * best.mean_carriers.u,
                                                    (1 / total) * best.mean_carriers.v}
                                         : best.carriers;
          best.center_px = {corner.x + mid, corner.y + mid};
          best.screen_at_center =
              Vec2{dot(best.carriers.u, {mid, mid}), dot(best.carriers.v, {mid, mid})} +
              seed_screen;
          for (std::size_t k = 0; k < 3; ++k) {
            for (std::size_t c = 0; c < 3; ++c)
              best.response[static_cast<std::size_t>(color[k])][c] =
                  response[k](static_cast<Eigen::Index>(c));
          }
        }
        best.layout = layout;
        best.explained = explained;
        best.sigma_px = sigma;
      }
    }
  }
  // Squares look the same turned by 90 degrees: u within 45 degrees of the scan's y.
  if (layout_sites(best.layout).square &&
      std::abs(best.carriers.v.y) > std::abs(best.carriers.v.x)) {
    best.carriers = {best.carriers.v, -1.0 * best.carriers.u};
    best.mean_carriers = {best.mean_carriers.v, -1.0 * best.mean_carriers.u};
    best.screen_at_center = {best.screen_at_center.y, -best.screen_at_center.x};
  }
  best.other_explained = best_of[best.layout == ScreenLayout::kTwoSites ? 0 : 1];
  return best;
}

}  // namespace reseau
