#include "calibration/random/random_target.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>

#include <Eigen/Core>

#include "calibration/random/place_fit.h"
#include "calibration/random/random_psf_fit.h"
#include "calibration/random/spline_cells.h"
#include "calibration/random/spread_prior.h"

namespace reseau {
namespace {

using random_target::BlurredPlace;
using random_target::kTerms;
using random_target::PlaceInTarget;
using random_target::SplineCells;
using random_target::SpreadPrior;
using random_target::SpreadStep;
using random_target::SpreadSystem;
using random_target::Terms;
using random_target::UsedPart;

constexpr int kLeastSide = 48;
constexpr double kMostLeftOut = 0.02;  // of the samples
constexpr double kLeastShare = 1e-7;   // of curvatures
constexpr double kAside_px = 0.005;    // step of numerical derivatives
constexpr int kRounds = 2;
// After the knots: dark level, growth of the light, place without its shift.
constexpr Eigen::Index kLevels = 3, kPlaces = 2 * (kTerms - 1);

struct Normal {
  Eigen::MatrixXd matrix;  // whole
  Eigen::VectorXd right;
  double squares = 0, n = 0;
};

struct Model {
  int n_knots = 0;  // along an axis
  double step_px = 0.5;
  PlaceInTarget place;
  Eigen::VectorXd knots;  // times contrast
  double dark = 0, light_x = 0, light_y = 0;
};

// Of what the model leaves over, by all that is free.
Normal gather(const UsedPart& part, SplineCells& cells, const Model& model) {
  const Eigen::Index n_knots2 = model.knots.size(), n = n_knots2 + kLevels + kPlaces;
  Normal out{Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd::Zero(n), 0, 0};
  constexpr Eigen::Index kBlock = 64;
  Eigen::MatrixXd rows(n, kBlock);
  Eigen::VectorXd rest(kBlock);
  Eigen::Index filled = 0;
  const auto flush = [&] {
    if (filled == 0) return;
    out.matrix.selfadjointView<Eigen::Lower>().rankUpdate(rows.leftCols(filled));
    out.right += rows.leftCols(filled) * rest.head(filled);
    out.squares += rest.head(filled).squaredNorm();
    out.n += static_cast<double>(filled);
    filled = 0;
  };
  Eigen::VectorXd seen(n_knots2);
  const auto look = [&](Vec2 at) {
    cells.features(at.x, at.y, {seen.data(), static_cast<std::size_t>(n_knots2)});
    return seen.dot(model.knots);
  };
  const Vec2 middle = part.middle();
  for (int y = 0; y < part.samples.height(); ++y) {
    for (int x = 0; x < part.samples.width(); ++x) {
      const double value = static_cast<double>(part.samples(x, y));
      if (!std::isfinite(value)) continue;
      const double px = (x - middle.x) / part.half_px(), py = (y - middle.y) / part.half_px();
      const Terms terms = PlaceInTarget::terms(px, py);
      const Vec2 at = model.place.at(terms);
      const double gain = 1 + model.light_x * px + model.light_y * py;
      const double beside_u = look({at.x + kAside_px, at.y});
      const double beside_v = look({at.x, at.y + kAside_px});
      const double light = look(at);
      const double by_u = gain * (beside_u - light) / kAside_px;
      const double by_v = gain * (beside_v - light) / kAside_px;
      auto row = rows.col(filled);
      row.head(n_knots2) = gain * seen;
      row[n_knots2] = 1;
      row[n_knots2 + 1] = light * px;
      row[n_knots2 + 2] = light * py;
      for (int k = 1; k < kTerms; ++k) {
        row[n_knots2 + kLevels + k - 1] = by_u * terms[static_cast<std::size_t>(k)];
        row[n_knots2 + kLevels + kTerms - 1 + k - 1] = by_v * terms[static_cast<std::size_t>(k)];
      }
      rest[filled] = value - model.dark - gain * light;
      if (++filled == kBlock) flush();
    }
  }
  flush();
  out.matrix = out.matrix.selfadjointView<Eigen::Lower>();
  return out;
}

// What the spread's values at the knots say of its shift against a Gaussian: rows by knots.
struct Shift {
  Eigen::VectorXd u, v;
};
Shift shift_rows(int n_knots, double step_px, double sigma2_u, double sigma2_v) {
  const Eigen::Index n = n_knots;
  Eigen::VectorXd slope_u(n * n), slope_v(n * n);
  for (Eigen::Index j = 0; j < n; ++j) {
    for (Eigen::Index i = 0; i < n; ++i) {
      const double u = random_target::from_middle(i, n) * step_px;
      const double v = random_target::from_middle(j, n) * step_px;
      const double g = std::exp(-u * u / (2 * sigma2_u) - v * v / (2 * sigma2_v)) /
                       (2 * std::numbers::pi * std::sqrt(sigma2_u * sigma2_v));
      slope_u[j * n + i] = -u / sigma2_u * g;
      slope_v[j * n + i] = -v / sigma2_v * g;
    }
  }
  const double squares_u = slope_u.squaredNorm(), squares_v = slope_v.squaredNorm();
  Shift out{Eigen::VectorXd::Zero(n * n), Eigen::VectorXd::Zero(n * n)};
  for (Eigen::Index j = 0; j < n; ++j) {
    for (Eigen::Index i = 0; i < n; ++i) {
      // The knots around a sample are what it is made of.
      for (Eigen::Index dj = -1; dj <= 1; ++dj) {
        for (Eigen::Index di = -1; di <= 1; ++di) {
          const Eigen::Index kj = j + dj, ki = i + di;
          if (kj < 0 || ki < 0 || kj >= n || ki >= n) continue;
          const double w = random_target::cubic_spline(static_cast<double>(di)) *
                           random_target::cubic_spline(static_cast<double>(dj)) /
                           (step_px * step_px);
          out.u[kj * n + ki] -= w * slope_u[j * n + i] / squares_u;
          out.v[kj * n + ki] -= w * slope_v[j * n + i] / squares_v;
        }
      }
    }
  }
  return out;
}

double largest_bend(const PlaceInTarget& place) {
  double most = 0;
  for (const double x : {-1.0, 0.0, 1.0}) {
    for (const double y : {-1.0, 0.0, 1.0}) {
      const Terms t = PlaceInTarget::terms(x, y);
      Vec2 bend{0, 0};
      for (std::size_t k = 3; k < t.size(); ++k) {
        bend = bend + Vec2{place.u[k] * t[k], place.v[k] * t[k]};
      }
      most = std::max(most, norm(bend));
    }
  }
  return most;
}

// The part in the middle, without what is clipped or no number.
struct Samples {
  std::vector<float> values;
  int side = 0, x0 = 0, y0 = 0;
  double left_out = 0, spread = 0;
};
Samples samples_of(Span2D<const float> all, const RandomOptions& options) {
  Samples out;
  out.side = std::min({options.most_px, all.width(), all.height()});
  out.x0 = (all.width() - out.side) / 2;
  out.y0 = (all.height() - out.side) / 2;
  double sum = 0, squares = 0, n = 0;
  for (int y = 0; y < out.side; ++y) {
    for (int x = 0; x < out.side; ++x) {
      const float v = all(out.x0 + x, out.y0 + y);
      const double value = static_cast<double>(v);
      const bool good = std::isfinite(v) && value > options.lowest && value < options.highest &&
                        std::abs(value) < 1e12;
      out.values.push_back(good ? v : std::numeric_limits<float>::quiet_NaN());
      if (!good) continue;
      sum += value;
      squares += value * value;
      n += 1;
    }
  }
  const double count = static_cast<double>(out.values.size());
  out.left_out = count > 0 ? 1 - n / count : 1;
  if (n > 0) out.spread = std::sqrt(std::max(0.0, squares / n - sum * sum / (n * n)));
  return out;
}

}  // namespace

RandomPsf measure_random(Span2D<const float> all, const RandomCells& cells,
                         const RandomOptions& options, const RandomPsf* start) {
  RandomPsf out;
  const auto refused = [&](RandomStatus why) {
    out.status = why;
    return out;
  };
  if (std::min(all.width(), all.height()) < kLeastSide) return refused(RandomStatus::kTooSmall);
  const Samples samples = samples_of(all, options);
  out.left_out = samples.left_out;
  out.side_used_px = samples.side;
  if (samples.left_out > kMostLeftOut) return refused(RandomStatus::kNoSamples);
  if (!(samples.spread > 0)) return refused(RandomStatus::kNoContrast);
  const int n = options.support_px * options.per_px / 2 * 2 + 1;
  const Eigen::Index n2 = static_cast<Eigen::Index>(n) * n;
  if (static_cast<Eigen::Index>(samples.values.size()) < 2 * n2) {
    return refused(RandomStatus::kTooFewSamples);
  }
  const UsedPart part{Span2D<const float>(samples.values.data(), samples.side, samples.side)};
  const BlurredPlace* near = start != nullptr && start->fit ? &start->fit->blurred : nullptr;
  const std::optional<BlurredPlace> found = random_target::find_place(part, cells, near);
  if (!found) return refused(RandomStatus::kOtherTarget);

  Model model;
  model.n_knots = n;
  model.step_px = 1.0 / options.per_px;
  model.place = found->place;
  model.dark = found->dark;
  model.light_x = found->light_x;
  model.light_y = found->light_y;
  // The Gaussian that was found, as knots.
  model.knots.resize(n2);
  for (Eigen::Index k = 0; k < n2; ++k) {
    const double u = random_target::from_middle(k % n, n) * model.step_px;
    const double v = random_target::from_middle(k / n, n) * model.step_px;
    model.knots[k] = std::exp(-u * u / (2 * found->sigma2_u) - v * v / (2 * found->sigma2_v));
  }
  model.knots *= found->contrast / model.knots.sum();
  const Shift shift = shift_rows(n, model.step_px, found->sigma2_u, found->sigma2_v);
  const Eigen::VectorXd gaussian = model.knots / model.knots.sum();
  Eigen::VectorXd rest = Eigen::VectorXd::Zero(n2);
  double of_gaussian = found->contrast;
  SplineCells seen(cells, n, model.step_px);
  std::optional<SpreadPrior> prior;
  SpreadStep step;
  Vec2 last{0, 0};
  for (int round = 0; round < kRounds; ++round) {
    const Normal normal = gather(part, seen, model);
    const SpreadSystem system{normal.matrix, normal.right, normal.squares,
                              normal.n,      gaussian,     rest};
    if (round == 0) {
      out.weakest_share =
          random_target::weakest_in_band(normal.matrix.topLeftCorner(n2, n2), n, model.step_px);
      if (!(out.weakest_share > kLeastShare)) return refused(RandomStatus::kNotTold);
      prior.emplace(system, n, model.step_px, found->sigma2_u, found->sigma2_v);
    }
    const bool is_last = round + 1 == kRounds;
    step = prior->solve(system, is_last);
    if (!step.rest.allFinite() || !step.others.allFinite()) return refused(RandomStatus::kNotTold);
    rest = step.rest;
    of_gaussian += step.contrast;
    model.knots = of_gaussian * gaussian + rest;
    model.dark += step.others[0];
    model.light_x += step.others[1];
    model.light_y += step.others[2];
    for (std::size_t k = 1; k < kTerms; ++k) {
      const auto at = static_cast<Eigen::Index>(k) - 1;
      model.place.u[k] += step.others[kLevels + at];
      model.place.v[k] += step.others[kLevels + kTerms - 1 + at];
    }
    const double sum = model.knots.sum();
    if (!(sum > 0)) return refused(RandomStatus::kOtherTarget);
    last = {shift.u.dot(model.knots) / sum, shift.v.dot(model.knots) / sum};
    if (is_last) break;
    // The knots are solved anew about the place where their middle is.
    model.place.u[0] -= last.x;
    model.place.v[0] -= last.y;
  }
  const double contrast = model.knots.sum();

  auto fit = std::make_shared<RandomPsf::Fit>();
  fit->blurred = *found;
  fit->n_knots = n;
  fit->step_px = model.step_px;
  fit->knots = model.knots;
  fit->covariance = step.covariance;
  const double half = part.half_px();
  const Mat2 slope = model.place.slope();
  fit->target_from_scan = {slope.a / half, slope.b / half, slope.c / half, slope.d / half};
  fit->shift_u = shift.u;
  fit->shift_v = shift.v;
  out.fit = fit;
  out.middle_px = {samples.x0 + part.middle().x, samples.y0 + part.middle().y};
  out.origin_px = {model.place.u[0] - last.x, model.place.v[0] - last.y};
  const auto sd_of = [&](const Eigen::VectorXd& row) {
    return std::sqrt(std::max(0.0, row.dot(fit->covariance * row)));
  };
  const auto by_knots = [&](const Eigen::VectorXd& row, double value) {
    return Eigen::VectorXd((row.array() - value) / contrast);
  };
  out.origin_sd_px = {sd_of(by_knots(shift.u, last.x)), sd_of(by_knots(shift.v, last.y))};
  out.scale = fit->target_from_scan;
  out.mirrored = out.scale.determinant() < 0;
  out.turn_deg = std::atan2(out.scale.c, out.scale.a) * 180 / std::numbers::pi;
  out.bend_px = largest_bend(model.place);
  out.dark = model.dark;
  out.contrast = contrast;
  out.noise = std::sqrt(step.variance) / contrast;
  fill_samples(out);
  find_tails(out);
  return out;
}

}  // namespace reseau
