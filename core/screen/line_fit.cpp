#include "core/screen/line_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/screen/cubic_spline.h"

namespace reseau {
namespace {

// An error is believed where left-out strips gain so much [nats each], a variance lower by a fifth,
// and more where few of them speak: the gain of n strips scatters by about 1 / sqrt(n).
constexpr double kLeastGain = 0.10, kGainScatter = 2;
constexpr double kLeastAmplitudePx = 0.008;

struct Strip {
  double position, value, weight;
  int fold;
};

// Symmetric matrix of half-bandwidth 3, solved by Cholesky's method.
class Band {
 public:
  explicit Band(std::size_t n) : rows_(n), right_(n, 0) {}
  double& at(std::size_t i, std::size_t j) { return rows_[i][i - j]; }  // j <= i
  double& right(std::size_t i) { return right_[i]; }
  [[nodiscard]] std::vector<double> solve() {
    const std::size_t n = rows_.size();
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t k = std::min<std::size_t>(i, 3); k > 0; --k) {
        const std::size_t j = i - k;
        double sum = rows_[i][k];
        for (std::size_t m = k + 1; m <= 3 && m <= i; ++m) {
          if (m - k <= 3) sum -= rows_[i][m] * rows_[j][m - k];
        }
        rows_[i][k] = sum / rows_[j][0];
      }
      double diagonal = rows_[i][0];
      for (std::size_t k = 1; k <= std::min<std::size_t>(i, 3); ++k)
        diagonal -= rows_[i][k] * rows_[i][k];
      rows_[i][0] = std::sqrt(std::max(diagonal, 1e-300));
    }
    std::vector<double> x = right_;
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t k = 1; k <= std::min<std::size_t>(i, 3); ++k) x[i] -= rows_[i][k] * x[i - k];
      x[i] /= rows_[i][0];
    }
    for (std::size_t i = n; i-- > 0;) {
      for (std::size_t k = 1; k <= 3 && i + k < n; ++k) x[i] -= rows_[i + k][k] * x[i + k];
      x[i] /= rows_[i][0];
    }
    return x;
  }

 private:
  std::vector<std::array<double, 4>> rows_;
  std::vector<double> right_;
};

double median_of(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::size_t coefficients_for(double extent, double spacing) {
  return static_cast<std::size_t>(std::max(4.0, std::ceil(extent / spacing) + 3));
}

double value_at(const std::vector<double>& coefficients, double spacing, double position) {
  const SplineInterval at =
      locate_interval(position, spacing, static_cast<int>(coefficients.size()));
  const SplineWeights w = spline_weights(at.t);
  double sum = 0;
  for (std::size_t k = 0; k < 4; ++k)
    sum += w.value[k] * coefficients[static_cast<std::size_t>(at.index) + k];
  return sum;
}

// Weighted smoothing spline; where there are no strips it is drawn straight, then to zero.
std::vector<double> fit_spline(const std::vector<Strip>& strips, int without_fold, double extent,
                               double spacing) {
  const std::size_t n = coefficients_for(extent, spacing);
  std::vector<double> coefficients(n, 0.0);
  std::vector<double> robust(strips.size(), 1.0);
  for (int round = 0; round < 3; ++round) {
    Band band(n);
    double total = 0;
    std::size_t used = 0;
    for (std::size_t s = 0; s < strips.size(); ++s) {
      const Strip& strip = strips[s];
      if (strip.fold == without_fold || !(strip.weight > 0)) continue;
      const SplineInterval at = locate_interval(strip.position, spacing, static_cast<int>(n));
      const SplineWeights w = spline_weights(at.t);
      const double weight = strip.weight * robust[s];
      total += weight;
      ++used;
      for (std::size_t i = 0; i < 4; ++i) {
        const std::size_t row = static_cast<std::size_t>(at.index) + i;
        band.right(row) += weight * w.value[i] * strip.value;
        for (std::size_t j = 0; j <= i; ++j)
          band.at(row, static_cast<std::size_t>(at.index) + j) += weight * w.value[i] * w.value[j];
      }
    }
    if (used == 0) return coefficients;
    const double unit = total / static_cast<double>(n);
    for (std::size_t i = 0; i + 2 < n; ++i) {
      const std::array<double, 3> stencil{1, -2, 1};
      for (std::size_t a = 0; a < 3; ++a) {
        for (std::size_t b = 0; b <= a; ++b)
          band.at(i + a, i + b) += 2e-3 * unit * stencil[a] * stencil[b];
      }
    }
    for (std::size_t i = 0; i < n; ++i) band.at(i, i) += 1e-4 * unit;
    coefficients = band.solve();
    std::vector<double> sizes;
    for (const Strip& strip : strips) {
      if (strip.fold == without_fold || !(strip.weight > 0)) continue;
      sizes.push_back(std::abs(strip.value - value_at(coefficients, spacing, strip.position)) *
                      std::sqrt(strip.weight));
    }
    const double scale = std::max(1.4826 * median_of(sizes), 1e-9);
    for (std::size_t s = 0; s < strips.size(); ++s) {
      const double k = (strips[s].value - value_at(coefficients, spacing, strips[s].position)) *
                       std::sqrt(strips[s].weight) / (2.5 * scale);
      robust[s] = 1 / (1 + k * k);
    }
  }
  return coefficients;
}

std::vector<Strip> strips_of(const std::vector<LineSample>& samples, LineError::Axis axis,
                             double strip_px, bool along_x) {
  std::vector<Strip> strips;
  constexpr double kMostInfo = 1 / (0.004 * 0.004);  // the picture errs by as much
  for (const LineSample& sample : samples) {
    const bool columns = axis == LineError::Axis::kColumns;
    const double across = columns ? sample.p_in_scan.y : sample.p_in_scan.x;
    strips.push_back({columns ? sample.p_in_scan.x : sample.p_in_scan.y,
                      along_x ? sample.off_px.x : sample.off_px.y,
                      std::min(along_x ? sample.info_x : sample.info_y, kMostInfo),
                      static_cast<int>(std::floor((across + 0.5) / strip_px)) & 1});
  }
  return strips;
}

// Variance of the error at every coefficient's own place, from the strips' scatter about the fit
// and the same equations as the fit: towards the ends, and where there are no strips, it grows, at
// most to what the error is elsewhere.
std::vector<double> spline_variance(const std::vector<Strip>& strips,
                                    const std::vector<double>& fitted,
                                    const std::vector<double>& whole, double spacing) {
  const std::size_t n = fitted.size();
  std::vector<double> sizes;
  for (const Strip& strip : strips) {
    if (strip.weight > 0)
      sizes.push_back(std::abs(strip.value - value_at(fitted, spacing, strip.position)) *
                      std::sqrt(strip.weight));
  }
  const double excess = std::max(std::pow(1.4826 * median_of(sizes), 2), 1e-6);
  double square = 0;
  for (const double value : whole) square += value * value;
  const double most = std::max(square / static_cast<double>(n), 1e-12);
  // What a cubic spline of this spacing cannot follow: fourth differences over 384.
  double bends = 0;
  for (std::size_t i = 0; i + 4 < n; ++i) {
    const double fourth =
        whole[i] - 4 * whole[i + 1] + 6 * whole[i + 2] - 4 * whole[i + 3] + whole[i + 4];
    bends += fourth * fourth;
  }
  bends /= 384.0 * 384.0 * static_cast<double>(n);
  std::vector<double> variance(n);
  for (std::size_t k = 0; k < n; ++k) {
    const double extent = (static_cast<double>(n) - 3) * spacing;
    const double position =
        std::clamp((static_cast<double>(k) - 1) * spacing, 0.0, extent - 1e-9 * spacing);
    const SplineInterval at = locate_interval(position, spacing, static_cast<int>(n));
    const SplineWeights w = spline_weights(at.t);
    // Only what lies near has a say: a window of the equations about the place.
    constexpr std::size_t kReach = 12;
    const auto first_weight = static_cast<std::size_t>(at.index);
    const std::size_t first = first_weight > kReach ? first_weight - kReach : 0,
                      end = std::min(n, first_weight + 4 + kReach);
    Band band(end - first);
    for (const Strip& strip : strips) {
      if (!(strip.weight > 0)) continue;
      const SplineInterval in = locate_interval(strip.position, spacing, static_cast<int>(n));
      const auto row = static_cast<std::size_t>(in.index);
      if (row < first || row + 4 > end) continue;
      const SplineWeights v = spline_weights(in.t);
      for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t j = 0; j <= i; ++j)
          band.at(row - first + i, row - first + j) +=
              strip.weight / excess * v.value[i] * v.value[j];
      }
    }
    for (std::size_t i = 0; i < end - first; ++i) band.at(i, i) += 1 / most;
    for (std::size_t i = 0; i < 4; ++i) band.right(first_weight - first + i) = w.value[i];
    const std::vector<double> x = band.solve();
    double sum = 0;
    for (std::size_t i = 0; i < 4; ++i) sum += w.value[i] * x[first_weight - first + i];
    variance[k] = sum + bends;
  }
  return variance;
}

struct Trial {
  double gain = -1e9;  // the lesser of both folds [nats per strip]
  double rms_px = 0;   // of the error, where strips are sure of it
};

// How much better each half is predicted by the other than by nothing.
Trial try_spacing(const std::vector<Strip>& strips, double extent, double spacing) {
  Trial trial;
  trial.gain = 1e9;
  for (const int fold : {0, 1}) {
    const std::vector<double> fitted = fit_spline(strips, fold, extent, spacing);
    std::vector<double> sizes;
    for (const Strip& strip : strips) {
      if (strip.fold != fold || !(strip.weight > 0)) continue;
      sizes.push_back(std::abs(strip.value - value_at(fitted, spacing, strip.position)) *
                      std::sqrt(strip.weight));
    }
    if (sizes.size() < 8) return {};
    const double scale = std::max(1.4826 * median_of(sizes), 1e-9);
    double gain = 0, sum = 0, weight = 0;
    int n = 0;
    for (const Strip& strip : strips) {
      if (strip.fold != fold || !(strip.weight > 0)) continue;
      const double k = std::sqrt(strip.weight) / scale;
      const double value = value_at(fitted, spacing, strip.position);
      const double before = k * strip.value, after = k * (strip.value - value);
      gain += 0.5 * (std::log1p(before * before) - std::log1p(after * after));
      sum += strip.weight * value * value;
      weight += strip.weight;
      ++n;
    }
    trial.gain = std::min(trial.gain, gain / n);
    trial.rms_px = std::max(trial.rms_px, std::sqrt(sum / weight));
  }
  return trial;
}

}  // namespace

LineFit fit_line_error(const std::vector<LineSample>& samples, LineError::Axis axis,
                       double strip_px, double extent_px, double finest_px) {
  LineFit best;
  const std::vector<Strip> x = strips_of(samples, axis, strip_px, true),
                           y = strips_of(samples, axis, strip_px, false);
  double best_spacing = 0, best_gain = 0;
  const double of_a_fold = std::max(1.0, 0.5 * static_cast<double>(samples.size()));
  const double least_gain = kLeastGain + kGainScatter / std::sqrt(of_a_fold);
  for (double spacing = 32 * finest_px; spacing >= finest_px; spacing /= 2) {
    if (spacing > extent_px / 2) continue;
    const Trial tx = try_spacing(x, extent_px, spacing), ty = try_spacing(y, extent_px, spacing);
    const double gain = std::max(tx.gain, 0.0) + std::max(ty.gain, 0.0);
    // A looser error must earn what it adds.
    const bool large = std::hypot(tx.rms_px, ty.rms_px) > kLeastAmplitudePx;
    if (large && gain > least_gain && gain > best_gain + 0.01) {
      best_gain = gain;
      best_spacing = spacing;
    }
  }
  if (!(best_spacing > 0)) return best;
  best.gain = best_gain;
  best.error.axis = axis;
  best.error.spacing_px = best_spacing;
  best.error.coefficients.assign(coefficients_for(extent_px, best_spacing), Vec2{});
  best.error = improve_line_error(samples, best.error);
  double sum = 0;
  int n = 0;
  for (double at = 0; at < extent_px; at += best_spacing / 4, ++n) {
    const Vec2 e = best.error.at_position(at);
    sum += dot(e, e);
  }
  best.rms_px = std::sqrt(sum / n);
  return best;
}

LineError improve_line_error(const std::vector<LineSample>& samples, const LineError& known) {
  LineError better = known;
  const double extent = (static_cast<double>(known.coefficients.size()) - 3) * known.spacing_px;
  const std::vector<Strip> strips_x = strips_of(samples, known.axis, extent, true),
                           strips_y = strips_of(samples, known.axis, extent, false);
  const std::vector<double> x = fit_spline(strips_x, -1, extent, known.spacing_px),
                            y = fit_spline(strips_y, -1, extent, known.spacing_px);
  for (std::size_t i = 0; i < better.coefficients.size() && i < x.size(); ++i)
    better.coefficients[i] = better.coefficients[i] + Vec2{x[i], y[i]};
  std::vector<double> whole_x, whole_y;
  for (const Vec2& value : better.coefficients) {
    whole_x.push_back(value.x);
    whole_y.push_back(value.y);
  }
  const std::vector<double> var_x = spline_variance(strips_x, x, whole_x, known.spacing_px),
                            var_y = spline_variance(strips_y, y, whole_y, known.spacing_px);
  better.variance_px2.clear();
  for (std::size_t i = 0; i < better.coefficients.size() && i < var_x.size(); ++i)
    better.variance_px2.push_back({var_x[i], var_y[i]});
  return better;
}

}  // namespace reseau
