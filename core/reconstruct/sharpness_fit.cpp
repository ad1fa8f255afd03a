#include "core/reconstruct/sharpness_fit.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include <Eigen/Dense>

#include "core/screen/element_model.h"

namespace reseau {
namespace {

// The printed widths are not exactly those of the pattern: amplitudes are believed to this much of
// the mean, however little noise there is.
constexpr double kModelError = 0.015;

using Amplitudes = ElementModel::Amplitudes;
using Scatter = Eigen::Matrix<double, kTileAmplitudes, kTileAmplitudes>;

double square(double x) { return x * x; }

double left_over(const BlurTable::Left& left, const Scatter& scatter) {
  return (left.transpose() * scatter * left).trace();
}

}  // namespace

double tile_weight(const ScreenTile& tile, std::size_t channel) {
  const double mean = tile.amplitude[channel][0];
  return 1 / (tile.variance[channel] / tile.n_effective + kModelError * kModelError * mean * mean +
              1e-14);
}

namespace {

// Tiles whose blur is the same multiple of their channel's: the sum of y y^T / variance, less what
// the odd amplitudes say of noise and detail. All that a fit needs, because what the best three
// intensities of every tile leave is the trace of the residual projector with it.
struct Group {
  int step = 0;  // in the table of blurs, from the channel's own
  Scatter scatter = Scatter::Zero();
};

std::vector<Group> channel_groups(const SharpnessTask& task, const std::vector<ScreenTile>& tiles,
                                  std::size_t channel) {
  std::map<int, Group> groups;
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    const ScreenTile& tile = tiles[t];
    if (!tile.used) continue;
    const double relative = task.relative_blur ? task.relative_blur(t, channel) : 1.0;
    const int step =
        static_cast<int>(std::lround(std::log(relative) / std::log(BlurTable::kRatio)));
    Group& group = groups[step];
    group.step = step;
    const Amplitudes even = weighted_amplitudes(tile.amplitude[channel]),
                     odd = weighted_amplitudes(tile.odd[channel]);
    const double weight = tile_weight(tile, channel);
    group.scatter += weight * (even * even.transpose());
    for (int i = 1; i < kTileAmplitudes; ++i) group.scatter(i, i) -= weight * odd(i) * odd(i);
  }
  std::vector<Group> out;
  out.reserve(groups.size());
  for (const auto& [step, group] : groups) out.push_back(group);
  return out;
}

// Weak beliefs, in standard deviations.
constexpr double kInfraredPriorSd = 0.15;
constexpr double kWidthPriorSd = 0.04, kMostWidthChange = 0.16;
constexpr double kStretchPriorSd = 0.15, kMostStretch = 0.6;

// Joint fit of the widths and the stretch, shared, and a sigma per channel.
class SharpnessProblem {
 public:
  SharpnessProblem(const SharpnessTask& task, const std::vector<ScreenTile>& tiles) : task_(task) {
    for (std::size_t c = 0; c < task.n_channels; ++c)
      groups_.push_back(channel_groups(task, tiles, c));
  }

  [[nodiscard]] SharpnessFit solve() const {
    SharpnessFit fit;
    fit.printed = task_.printed;
    fit.shape = task_.shape;
    fit.widths = task_.printed.usual;
    double best = best_sigmas(fit.widths, fit.shape, fit.sigma);
    // Widths and stretch by a pattern search; for each, every channel has its own best sigma.
    for (double step = 0.04; step > 0.001; step *= 0.5) {
      for (bool moved = true; moved;) {
        moved = false;
        for (int direction = task_.printed.lines ? 0 : 4; direction < 6; ++direction) {
          const double by = direction % 2 == 0 ? step : -step;
          ScreenWidths widths = fit.widths;
          BlurShape shape = fit.shape;
          (direction < 2   ? widths.line
           : direction < 4 ? widths.first
                           : shape.stretch) += direction < 4 ? by : 2 * by;
          if (!allowed(widths, shape)) continue;
          std::array<double, 4> sigma = fit.sigma;
          const double value = best_sigmas(widths, shape, sigma);
          if (value < best - 1e-9) {
            best = value;
            fit.widths = widths;
            fit.shape = shape;
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
  [[nodiscard]] bool allowed(const ScreenWidths& widths, const BlurShape& shape) const {
    return std::abs(widths.line - task_.printed.usual.line) <= kMostWidthChange &&
           std::abs(widths.first - task_.printed.usual.first) <= kMostWidthChange &&
           std::abs(shape.stretch) <= kMostStretch;
  }

  [[nodiscard]] double shared_prior(const ScreenWidths& widths, const BlurShape& shape) const {
    return square((widths.line - task_.printed.usual.line) / kWidthPriorSd) +
           square((widths.first - task_.printed.usual.first) / kWidthPriorSd) +
           square(shape.stretch / kStretchPriorSd);
  }
  [[nodiscard]] double sigma_prior(std::size_t c, const std::array<double, 4>& sigma) const {
    if (c == 3 && !task_.prior.infrared) {
      return square((sigma[3] - kInfraredSofter * (sigma[0] + sigma[1] + sigma[2]) / 3) /
                    kInfraredPriorSd);
    }
    return square((sigma[c] - task_.prior.sigma_px[c]) / task_.prior.sd_px[c]);
  }

  double best_sigmas(const ScreenWidths& widths, const BlurShape& shape,
                     std::array<double, 4>& sigma) const {
    const BlurTable table(ElementModel(task_.linear, task_.printed.pattern(widths)), shape);
    double total = shared_prior(widths, shape);
    for (std::size_t c = 0; c < task_.n_channels; ++c) {
      std::array<double, 4> trial = sigma;
      const auto cost = [&](int index) {
        double sum = 0;
        for (const Group& group : groups_[c])
          sum += left_over(table.left(std::clamp(index + group.step, 0, table.size() - 1)),
                           group.scatter);
        trial[c] = BlurTable::sigma_px(index);
        return sum + sigma_prior(c, trial);
      };
      constexpr int kCoarse = 4;
      int at = 0;
      double best = 1e300;
      for (int i = 0; i < table.size(); i += kCoarse) {
        const double value = cost(i);
        if (value < best) best = value, at = i;
      }
      for (int middle = at, i = std::max(0, middle - kCoarse + 1);
           i < std::min(table.size(), middle + kCoarse); ++i) {
        const double value = cost(i);
        if (value < best) best = value, at = i;
      }
      double index = at;
      if (at > 0 && at + 1 < table.size()) {
        const double before = cost(at - 1), after = cost(at + 1),
                     curvature = before - 2 * best + after;
        if (curvature > 0) {
          const double shift = 0.5 * (before - after) / curvature;
          index += shift;
          best -= 0.5 * curvature * shift * shift;
        }
      }
      sigma[c] = BlurTable::sigma_px(index);
      total += best;
    }
    return total;
  }

  // Covariance from the curvature of chi-squared in all parameters together.
  void uncertainty(SharpnessFit& fit) const {
    const int first = task_.printed.lines ? 3 : 1, n = static_cast<int>(task_.n_channels) + first;
    const auto total = [&](const Eigen::VectorXd& x) {
      const ScreenWidths widths =
          task_.printed.lines ? ScreenWidths{x(1), x(2)} : task_.printed.usual;
      BlurShape shape = fit.shape;
      shape.stretch = x(0);
      std::array<double, 4> sigma{};
      for (int i = first; i < n; ++i) sigma[static_cast<std::size_t>(i - first)] = x(i);
      const ElementModel model(task_.linear, task_.printed.pattern(widths));
      double sum = shared_prior(widths, shape);
      for (std::size_t c = 0; c < task_.n_channels; ++c) {
        sum += sigma_prior(c, sigma);
        for (const Group& group : groups_[c]) {
          const double here = sigma[c] * std::pow(BlurTable::kRatio, group.step);
          sum += left_over(left_of(model.columns(here, shape)), group.scatter);
        }
      }
      return sum;
    };
    Eigen::VectorXd x(n);
    x(0) = fit.shape.stretch;
    if (task_.printed.lines) x(1) = fit.widths.line, x(2) = fit.widths.first;
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
    const auto sd_of = [&](int i, double otherwise) {
      const double variance = covariance(i, i);
      return variance > 0 && std::isfinite(variance) ? std::sqrt(variance) : otherwise;
    };
    fit.stretch_sd = sd_of(0, kStretchPriorSd);
    for (std::size_t c = 0; c < task_.n_channels; ++c)
      fit.sd[c] = sd_of(static_cast<int>(c) + first, task_.prior.sd_px[c]);
  }

  const SharpnessTask& task_;
  std::vector<std::vector<Group>> groups_;  // of each channel
};

}  // namespace

SharpnessFit fit_sharpness(const SharpnessTask& task, const std::vector<ScreenTile>& tiles) {
  SharpnessFit fit = SharpnessProblem(task, tiles).solve();
  if (task.printed.lines || task.relative_blur) return fit;
  // The name was a guess: squares and discs of one period differ in the higher harmonics only.
  SharpnessTask other = task;
  other.printed.discs = !task.printed.discs;
  SharpnessFit better = SharpnessProblem(other, tiles).solve();
  return better.cost < fit.cost ? better : fit;
}

}  // namespace reseau
