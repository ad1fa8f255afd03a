#include "core/screen/lattice_hypothesis.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "core/base/parallel.h"
#include "core/screen/element_model.h"
#include "core/screen/screen_tile.h"

namespace reseau {
namespace {

using Complex = std::complex<double>;
constexpr int kPhases = 12;  // per axis, in the search for the origin of the cell
constexpr std::array<double, 4> kSigmas{0.45, 0.8, 1.3, 2.0};

// Complex coefficients of kTileHarmonics, one channel.
using Coefficients = std::array<Complex, kTileAmplitudes - 1>;

struct TileView {
  std::array<double, 4> mean{};
  std::array<Coefficients, 4> harmonic;
  std::array<double, 4> total{};  // alternating energy: harmonics and the rest
};

TileView view_of(const ScreenTile& tile) {
  TileView view;
  for (std::size_t c = 0; c < 4; ++c) {
    view.mean[c] = tile.amplitude[c][0];
    view.total[c] = tile.variance[c];
    for (std::size_t h = 0; h + 1 < kTileAmplitudes; ++h) {
      // a cos + b sin = Re((a - i b) e^(i t)); the coefficient of e^(i t) is half of that.
      view.harmonic[c][h] = {tile.amplitude[c][h + 1], -tile.odd[c][h + 1]};
      view.total[c] += 2 * std::norm(view.harmonic[c][h]);
    }
  }
  return view;
}

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

// What turns the phases of the harmonics when the cell's origin moves to `screen`.
Coefficients turns_to(Vec2 screen) {
  const Complex u = std::polar(1.0, -2 * std::numbers::pi * screen.x);
  const Complex v = std::polar(1.0, -2 * std::numbers::pi * screen.y);
  return {u, v, u * v, u * std::conj(v), u * u, v * v};  // as kTileHarmonics
}

// Amplitudes of a channel once its phases are turned: real parts, weighed.
ElementModel::Amplitudes turned(const TileView& view, std::size_t channel,
                                const Coefficients& turns) {
  ElementModel::Amplitudes y;
  y(0) = view.mean[channel];
  for (std::size_t h = 0; h + 1 < kTileAmplitudes; ++h) {
    const Complex& a = view.harmonic[channel][h];
    y(static_cast<int>(h) + 1) =
        std::numbers::sqrt2 * (a.real() * turns[h].real() - a.imag() * turns[h].imag());
  }
  return y;
}

class Judge {
 public:
  Judge(const ElementModel& model, double sigma, bool infrared)
      : n_channels_(infrared ? 4 : 3), columns_(model.columns(sigma)), qr_(columns_) {
    // What the best lights leave of any amplitudes y is y' * rest_ * y.
    rest_ = Projector::Identity() - columns_ * qr_.solve(Projector::Identity());
  }

  // Alternating energy that three lights behind the elements explain, mean fitted too.
  [[nodiscard]] double explained(const TileView& view, Vec2 screen) const {
    double sum = 0;
    const Coefficients turns = turns_to(screen);
    for (std::size_t c = 0; c < n_channels_; ++c) {
      const ElementModel::Amplitudes y = turned(view, c, turns);
      // What lies in the odd parts is unexplained as well.
      const double even = y.tail<kTileAmplitudes - 1>().squaredNorm();
      sum += (even - y.dot(rest_ * y)) / std::max(view.total[c], 1e-30);
    }
    return sum / static_cast<double>(n_channels_);
  }

  [[nodiscard]] Origin best_origin(const TileView& view) const {
    Origin best;
    best.explained = -1e30;
    const auto consider = [&](Vec2 screen) {
      const double value = explained(view, screen);
      if (value > best.explained) best = {screen, value};
    };
    for (int j = 0; j < kPhases; ++j) {
      for (int i = 0; i < kPhases; ++i)
        consider({i / static_cast<double>(kPhases), j / static_cast<double>(kPhases)});
    }
    for (double step = 0.4 / kPhases; step > 0.003; step *= 0.5) {
      const Vec2 center = best.screen;
      for (int j = -1; j <= 1; ++j) {
        for (int i = -1; i <= 1; ++i) consider(center + Vec2{i * step, j * step});
      }
    }
    return best;
  }

  // Lights of the three elements in a channel.
  [[nodiscard]] Eigen::Vector3d lights(const TileView& view, std::size_t channel,
                                       Vec2 screen) const {
    return qr_.solve(turned(view, channel, turns_to(screen)));
  }

 private:
  using Projector = Eigen::Matrix<double, kTileAmplitudes, kTileAmplitudes>;
  std::size_t n_channels_;
  ElementModel::Columns columns_;
  Eigen::ColPivHouseholderQR<ElementModel::Columns> qr_;
  Projector rest_;
};

// Response of each element from its lights in all tiles: regressed on the lights in infrared, or
// their principal direction with the size of the brightest.
Eigen::Vector3d element_response(const std::vector<Eigen::Vector4d>& lights, bool infrared) {
  if (infrared) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double norm = 0;
    for (const Eigen::Vector4d& x : lights) {
      sum += x(3) * x.head<3>();
      norm += x(3) * x(3);
    }
    return sum / std::max(norm, 1e-30);
  }
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  double brightest = 0;
  for (const Eigen::Vector4d& x : lights) {
    scatter += x.head<3>() * x.head<3>().transpose();
    brightest = std::max(brightest, x.head<3>().norm());
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter);
  const Eigen::Vector3d direction = eigen.eigenvectors().col(2);
  return (direction.sum() < 0 ? -brightest : brightest) * direction;
}

// Colour of a light relative to the mean of each channel over all tiles, so that neither exposure
// nor a cast decides.
struct Cast {
  Eigen::Vector3d inverse_mean;

  // Of the two squares the greener is green.
  [[nodiscard]] bool squares_exchanged(const Eigen::Vector3d& green,
                                       const Eigen::Vector3d& blue) const {
    const auto greenness = [&](const Eigen::Vector3d& x) {
      return x(1) * inverse_mean(1) - x(2) * inverse_mean(2);
    };
    return greenness(green) < greenness(blue);
  }
  [[nodiscard]] bool line_is_reddest(const std::array<Eigen::Vector3d, 3>& p) const {
    const auto redness = [&](const Eigen::Vector3d& x) {
      const Eigen::Vector3d y = x.cwiseProduct(inverse_mean).cwiseMax(0);
      return y(0) / std::max(y.sum(), 1e-12);
    };
    return redness(p[0]) > redness(p[1]) && redness(p[0]) > redness(p[2]);
  }
};

}  // namespace

LatticeHypothesis judge_lattice(const LinearRows& rows, const std::vector<TileCorner>& corners,
                                const std::vector<Carriers>& tile_carriers, int tile_size,
                                bool infrared) {
  struct Entry {
    TileView view;
    std::size_t tile;
  };
  std::vector<ScreenTile> measured(corners.size());
  parallel_for(static_cast<int>(corners.size()), [&](int task) {
    const auto t = static_cast<std::size_t>(task);
    // A tile is a small frame of its own; phases refer to its corner.
    LinearRows cut;
    cut.first = 0;
    cut.n = tile_size;
    cut.width_px = tile_size;
    for (std::size_t c = 0; c < 4; ++c) {
      cut.plane[c].resize(static_cast<std::size_t>(tile_size) *
                          static_cast<std::size_t>(tile_size));
      for (int y = 0; y < tile_size; ++y) {
        std::copy_n(rows.row(static_cast<int>(c), corners[t].y + y) + corners[t].x, tile_size,
                    cut.plane[c].begin() + static_cast<std::ptrdiff_t>(y) * tile_size);
      }
    }
    const Carriers& f = tile_carriers[t];
    measured[t] =
        measure_screen_tile(cut, 0, tile_size, ScreenMap({f.u.x, f.u.y, f.v.x, f.v.y}, {}));
  });
  std::vector<Entry> entries;
  for (std::size_t t = 0; t < corners.size(); ++t) {
    if (measured[t].used) entries.push_back({view_of(measured[t]), t});
  }
  LatticeHypothesis best;
  if (entries.empty()) return best;
  Cast cast{Eigen::Vector3d::Zero()};
  for (const Entry& entry : entries) {
    for (int c = 0; c < 3; ++c)
      cast.inverse_mean(c) += entry.view.mean[static_cast<std::size_t>(c)];
  }
  cast.inverse_mean = cast.inverse_mean.cwiseMax(1e-9).cwiseInverse();
  for (const bool exchange : {false, true}) {
    for (const double sigma : kSigmas) {
      double sum = 0, best_tile = -1e30;
      std::vector<Origin> origins;
      std::vector<TileView> views;
      std::size_t seed = 0;
      const auto carriers_of = [&](std::size_t tile) {
        const Carriers& f = tile_carriers[tile];
        return exchange ? Carriers{f.v, -1.0 * f.u} : f;
      };
      const Carriers& first = carriers_of(entries[0].tile);
      const ElementModel model({first.u.x, first.u.y, first.v.x, first.v.y}, {});
      const Judge judge(model, sigma, infrared);
      for (const Entry& entry : entries) {
        views.push_back(exchange ? exchanged(entry.view) : entry.view);
      }
      origins.resize(entries.size());
      parallel_for(static_cast<int>(entries.size()), [&](int e) {
        origins[static_cast<std::size_t>(e)] =
            judge.best_origin(views[static_cast<std::size_t>(e)]);
      });
      for (std::size_t e = 0; e < entries.size(); ++e) {
        sum += origins[e].explained;
        if (origins[e].explained > best_tile) {
          best_tile = origins[e].explained;
          seed = e;
        }
      }
      const double explained = sum / static_cast<double>(entries.size());
      if (!(explained > best.explained)) continue;
      std::array<Eigen::Vector3d, 3> response;
      std::array<std::vector<Eigen::Vector4d>, 3> lights;
      // Each tile may have green and blue exchanged or not; its own colours tell, so that all add
      // up.
      for (std::size_t e = 0; e < entries.size(); ++e) {
        const auto collect = [&](Vec2 screen) {
          std::array<Eigen::Vector4d, 3> x;
          for (std::size_t c = 0; c < 4; ++c) {
            const Eigen::Vector3d l = judge.lights(views[e], c, screen);
            for (std::size_t k = 0; k < 3; ++k)
              x[k](static_cast<Eigen::Index>(c)) = l(static_cast<Eigen::Index>(k));
          }
          return x;
        };
        std::array<Eigen::Vector4d, 3> x = collect(origins[e].screen);
        if (cast.squares_exchanged(x[1].head<3>(), x[2].head<3>())) {
          origins[e].screen.x += 0.5;
          x = collect(origins[e].screen);
        }
        const double weight = std::max(origins[e].explained, 0.0);
        for (std::size_t k = 0; k < 3; ++k) lights[k].push_back(weight * x[k]);
      }
      for (std::size_t k = 0; k < 3; ++k) response[k] = element_response(lights[k], infrared);
      best.colors_fit =
          cast.line_is_reddest(response) && !cast.squares_exchanged(response[1], response[2]);
      best.explained = explained;
      best.sigma_px = sigma;
      best.carriers = carriers_of(entries[seed].tile);
      const TileCorner& corner = corners[entries[seed].tile];
      const double mid = (tile_size - 1) / 2.0;
      best.center_px = {corner.x + mid, corner.y + mid};
      best.screen_at_center =
          Vec2{dot(best.carriers.u, {mid, mid}), dot(best.carriers.v, {mid, mid})} +
          origins[seed].screen;
      for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t c = 0; c < 3; ++c)
          best.response[k][c] = response[k](static_cast<Eigen::Index>(c));
      }
    }
  }
  return best;
}

}  // namespace reseau
