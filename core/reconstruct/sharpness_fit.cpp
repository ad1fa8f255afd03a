#include "core/reconstruct/sharpness_fit.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Dense>

namespace reseau {
namespace {

// The printed widths are not exactly those of the pattern: amplitudes are believed to this much of
// the mean, however little noise there is.
constexpr double kModelError = 0.015;

}  // namespace

double tile_weight(const ScreenTile& tile, std::size_t channel) {
  const double mean = tile.amplitude[channel][0];
  return 1 / (tile.variance[channel] / tile.n_effective + kModelError * kModelError * mean * mean +
              1e-14);
}

namespace {

using Amplitudes = ElementModel::Amplitudes;
using Scatter = Eigen::Matrix<double, kTileAmplitudes, kTileAmplitudes>;
using Columns = ElementModel::Columns;

// Sum over tiles of y y^T / variance, less what the odd amplitudes say of noise and detail: all
// that a fit needs, because what the best three intensities of every tile leave is the trace of the
// residual projector with it.
Scatter channel_scatter(const std::vector<ScreenTile>& tiles, std::size_t channel) {
  Scatter sum = Scatter::Zero();
  for (const ScreenTile& tile : tiles) {
    if (!tile.used) continue;
    const Amplitudes even = weighted_amplitudes(tile.amplitude[channel]),
                     odd = weighted_amplitudes(tile.odd[channel]);
    const double weight = tile_weight(tile, channel);
    sum += weight * (even * even.transpose());
    for (int i = 1; i < kTileAmplitudes; ++i) sum(i, i) -= weight * odd(i) * odd(i);
  }
  return sum;
}

// Weak beliefs, in standard deviations.
constexpr double kSigmaPriorPx = 0.7, kSigmaPriorSd = 0.5;
constexpr double kInfraredPriorSd = 0.15;
constexpr double kWidthPriorSd = 0.04, kMostWidthChange = 0.16;

// Joint fit of the widths, shared, and a sigma per channel.
class SharpnessProblem {
 public:
  SharpnessProblem(const PrintedScreen& printed, const Mat2& linear,
                   const std::vector<ScreenTile>& tiles, std::size_t n_channels)
      : printed_(printed), linear_(linear), n_channels_(n_channels) {
    for (std::size_t c = 0; c < n_channels; ++c) scatter_.push_back(channel_scatter(tiles, c));
  }

  [[nodiscard]] SharpnessFit solve() const {
    SharpnessFit fit;
    fit.printed = printed_;
    fit.widths = printed_.usual;
    double best = best_sigmas(fit.widths, fit.sigma);
    // The widths by a pattern search; for each, every channel has its own best sigma.
    for (double step = 0.04; printed_.lines && step > 0.001; step *= 0.5) {
      for (bool moved = true; moved;) {
        moved = false;
        for (const auto& [dr, dg] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
          const ScreenWidths trial{fit.widths.line + dr * step, fit.widths.first + dg * step};
          if (std::abs(trial.line - printed_.usual.line) > kMostWidthChange ||
              std::abs(trial.first - printed_.usual.first) > kMostWidthChange) {
            continue;
          }
          std::array<double, 4> sigma{};
          const double value = best_sigmas(trial, sigma);
          if (value < best - 1e-9) {
            best = value;
            fit.widths = trial;
            fit.sigma = sigma;
            moved = true;
          }
        }
      }
    }
    fit.cost = best;
    uncertainty(fit);
    return fit;
  }

 private:
  double channel_cost(const ElementModel& model, std::size_t c, double sigma) const {
    const Eigen::HouseholderQR<Columns> qr(model.columns(sigma));
    const Scatter q = qr.householderQ();
    const auto rest = q.rightCols<kTileAmplitudes - 3>();
    return (rest.transpose() * scatter_[c] * rest).trace();
  }

  static double square(double x) { return x * x; }

  double prior(const ScreenWidths& widths, const std::array<double, 4>& sigma) const {
    double sum = width_prior(widths);
    for (std::size_t c = 0; c < 3; ++c) sum += square((sigma[c] - kSigmaPriorPx) / kSigmaPriorSd);
    if (n_channels_ == 4) sum += infrared_prior(sigma);
    return sum;
  }
  [[nodiscard]] double width_prior(const ScreenWidths& widths) const {
    return square((widths.line - printed_.usual.line) / kWidthPriorSd) +
           square((widths.first - printed_.usual.first) / kWidthPriorSd);
  }
  static double infrared_prior(const std::array<double, 4>& sigma) {
    return square((sigma[3] - kInfraredSofter * (sigma[0] + sigma[1] + sigma[2]) / 3) /
                  kInfraredPriorSd);
  }

  double best_sigmas(const ScreenWidths& widths, std::array<double, 4>& sigma) const {
    const ElementModel model(linear_, printed_.pattern(widths));
    double total = width_prior(widths);
    for (std::size_t c = 0; c < n_channels_; ++c) {
      total += minimise(
          [&](double s) {
            std::array<double, 4> trial = sigma;
            trial[c] = s;
            return channel_cost(model, c, s) +
                   (c < 3 ? square((s - kSigmaPriorPx) / kSigmaPriorSd) : infrared_prior(trial));
          },
          sigma[c]);
    }
    return total;
  }

  template <typename Cost>
  static double minimise(const Cost& cost, double& at) {
    double best = 1e300;
    for (double s = kLeastSigmaPx; s <= kMostSigmaPx; s *= 1.1) {
      const double value = cost(s);
      if (value < best) {
        best = value;
        at = s;
      }
    }
    double low = std::max(at / 1.1, kLeastSigmaPx), high = std::min(at * 1.1, kMostSigmaPx);
    constexpr double kGolden = 0.6180339887498949;
    double a = high - kGolden * (high - low), b = low + kGolden * (high - low);
    double cost_a = cost(a), cost_b = cost(b);
    for (int i = 0; i < 18; ++i) {
      if (cost_a < cost_b) {
        high = b;
        b = a;
        cost_b = cost_a;
        a = high - kGolden * (high - low);
        cost_a = cost(a);
      } else {
        low = a;
        a = b;
        cost_a = cost_b;
        b = low + kGolden * (high - low);
        cost_b = cost(b);
      }
    }
    at = 0.5 * (low + high);
    return cost(at);
  }

  // Covariance from the curvature of chi-squared in all parameters together.
  void uncertainty(SharpnessFit& fit) const {
    const int first = printed_.lines ? 2 : 0, n = static_cast<int>(n_channels_) + first;
    const auto total = [&](const Eigen::VectorXd& x) {
      const ScreenWidths widths = printed_.lines ? ScreenWidths{x(0), x(1)} : printed_.usual;
      std::array<double, 4> sigma{};
      for (int i = first; i < n; ++i) sigma[static_cast<std::size_t>(i - first)] = x(i);
      const ElementModel model(linear_, printed_.pattern(widths));
      double sum = prior(widths, sigma);
      for (std::size_t c = 0; c < n_channels_; ++c) sum += channel_cost(model, c, sigma[c]);
      return sum;
    };
    Eigen::VectorXd x(n);
    if (printed_.lines) x(0) = fit.widths.line, x(1) = fit.widths.first;
    for (int i = first; i < n; ++i) x(i) = fit.sigma[static_cast<std::size_t>(i - first)];
    Eigen::MatrixXd hessian(n, n);
    constexpr double kStep = 0.01;
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j <= i; ++j) {
        const auto moved = [&](double a, double b) {
          Eigen::VectorXd y = x;
          y(i) += a * kStep;
          y(j) += b * kStep;
          return total(y);
        };
        hessian(i, j) = hessian(j, i) =
            (moved(1, 1) - moved(1, -1) - moved(-1, 1) + moved(-1, -1)) / (4 * kStep * kStep);
      }
    }
    const Eigen::MatrixXd covariance = 2 * hessian.fullPivLu().inverse();
    for (std::size_t c = 0; c < n_channels_; ++c) {
      const double variance = covariance(static_cast<int>(c) + first, static_cast<int>(c) + first);
      fit.sd[c] = variance > 0 && std::isfinite(variance) ? std::sqrt(variance) : kSigmaPriorSd;
    }
  }

  PrintedScreen printed_;
  Mat2 linear_;
  std::size_t n_channels_;
  std::vector<Scatter> scatter_;
};

}  // namespace

SharpnessFit fit_sharpness(const PrintedScreen& printed, const Mat2& linear,
                           const std::vector<ScreenTile>& tiles, std::size_t n_channels) {
  SharpnessFit fit = SharpnessProblem(printed, linear, tiles, n_channels).solve();
  if (printed.lines) return fit;
  // The name was a guess: squares and discs of one period differ in the higher harmonics only.
  PrintedScreen other = printed;
  other.discs = !printed.discs;
  SharpnessFit better = SharpnessProblem(other, linear, tiles, n_channels).solve();
  return better.cost < fit.cost ? better : fit;
}

}  // namespace reseau
