#include "calibration/random/place_fit.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "calibration/random/place_search.h"

namespace reseau::random_target {
namespace {

constexpr double kFirstSigma_px = 0.8;
constexpr double kLooksLike = 0.45;  // explained variance of the patch in the middle
constexpr double kIsTarget = 0.6;    // of the whole part
constexpr std::array<int, 5> kSides{40, 56, 80, 112, 160};

double normal_below(double z) { return 0.5 * std::erfc(-z / std::numbers::sqrt2); }

// What of the cells along an axis a Gaussian of variance sigma2 about `at` sees, with first and
// second derivative by `at`.
struct GaussianAxis {
  std::int64_t first = 0;
  std::vector<double> w, w1, w2;

  void set(const RandomCells& cells, double at, double sigma2) {
    const double sigma = std::sqrt(sigma2), reach = 4.5 * sigma;
    first = cells.cell_at(at - reach);
    const auto n = static_cast<std::size_t>(cells.cell_at(at + reach) - first) + 1;
    w.resize(n);
    w1.resize(n);
    w2.resize(n);
    double below = 0, slope = 0, bend = 0;
    for (std::size_t i = 0; i <= n; ++i) {
      const double z = (cells.border_px(first + static_cast<std::int64_t>(i)) - at) / sigma;
      const double density = std::exp(-z * z / 2) / (std::sqrt(2 * std::numbers::pi) * sigma);
      const double b = normal_below(z), s = -density, c = -z * density / sigma;
      if (i > 0) {
        w[i - 1] = b - below;
        w1[i - 1] = s - slope;
        w2[i - 1] = c - bend;
      }
      below = b;
      slope = s;
      bend = c;
    }
  }
};

// Light through the Gaussian, its slopes, and its derivatives by the two variances.
struct Seen {
  double value = 0, u = 0, v = 0, by_sigma2_u = 0, by_sigma2_v = 0;
};

class GaussianView {
 public:
  explicit GaussianView(const RandomCells& cells) : cells_(cells) {}
  Seen at(Vec2 place, double sigma2_u, double sigma2_v) {
    across_.set(cells_, place.x, sigma2_u);
    down_.set(cells_, place.y, sigma2_v);
    Seen out;
    for (std::size_t j = 0; j < down_.w.size(); ++j) {
      double sum = 0, slope = 0, bend = 0;
      for (std::size_t i = 0; i < across_.w.size(); ++i) {
        if (!cells_.clear(across_.first + static_cast<std::int64_t>(i),
                          down_.first + static_cast<std::int64_t>(j))) {
          continue;
        }
        sum += across_.w[i];
        slope += across_.w1[i];
        bend += across_.w2[i];
      }
      out.value += down_.w[j] * sum;
      out.u += down_.w[j] * slope;
      out.v += down_.w1[j] * sum;
      // A wider Gaussian is heat that spread: half the second derivative.
      out.by_sigma2_u += 0.5 * down_.w[j] * bend;
      out.by_sigma2_v += 0.5 * down_.w2[j] * sum;
    }
    return out;
  }

 private:
  const RandomCells& cells_;
  GaussianAxis across_, down_;
};

// Gauss's method on the square of `side` px about the middle, damped where a step does not help.
void refine(const UsedPart& part, const RandomCells& cells, int side, bool bent, BlurredPlace& at) {
  // u, v (bent: all terms), sigma2_u, sigma2_v, dark, contrast, light_x, light_y.
  const Eigen::Index n_terms = bent ? kTerms : 3, n = 2 * n_terms + 6;
  const Vec2 middle = part.middle();
  const int x0 = std::max(0, static_cast<int>(middle.x - side / 2.0 + 1));
  const int y0 = std::max(0, static_cast<int>(middle.y - side / 2.0 + 1));
  const int x1 = std::min(part.samples.width(), x0 + side);
  const int y1 = std::min(part.samples.height(), y0 + side);
  GaussianView view(cells);
  Eigen::MatrixXd normal(n, n);
  Eigen::VectorXd right(n), row(n);
  const auto gather = [&](const BlurredPlace& now, bool with_normal) {
    double misfit = 0, sum = 0, squares = 0, count = 0;
    if (with_normal) {
      normal.setZero();
      right.setZero();
    }
    for (int y = y0; y < y1; ++y) {
      for (int x = x0; x < x1; ++x) {
        const double value = static_cast<double>(part.samples(x, y));
        if (!std::isfinite(value)) continue;
        const double px = (x - middle.x) / part.half_px(), py = (y - middle.y) / part.half_px();
        const Terms terms = PlaceInTarget::terms(px, py);
        const Seen seen = view.at(now.place.at(terms), now.sigma2_u, now.sigma2_v);
        const double gain = 1 + now.light_x * px + now.light_y * py;
        const double model = now.dark + now.contrast * gain * seen.value;
        const double rest = value - model;
        misfit += rest * rest;
        sum += value;
        squares += value * value;
        count += 1;
        if (!with_normal) continue;
        const double height = now.contrast * gain;
        for (Eigen::Index k = 0; k < n_terms; ++k) {
          row[k] = height * seen.u * terms[static_cast<std::size_t>(k)];
          row[n_terms + k] = height * seen.v * terms[static_cast<std::size_t>(k)];
        }
        row.tail(6) << height * seen.by_sigma2_u, height * seen.by_sigma2_v, 1, gain * seen.value,
            now.contrast * seen.value * px, now.contrast * seen.value * py;
        normal.selfadjointView<Eigen::Lower>().rankUpdate(row);
        right += row * rest;
      }
    }
    if (count < 64) return std::pair{0.0, 0.0};
    return std::pair{misfit, std::max(0.0, squares - sum * sum / count)};
  };
  double damping = 1e-6;
  auto [misfit, variance] = gather(at, true);
  for (int round = 0; round < 12; ++round) {
    Eigen::MatrixXd damped = normal.selfadjointView<Eigen::Lower>();
    damped.diagonal() *= 1 + damping;
    damped.diagonal().array() += 1e-12 * damped.diagonal().maxCoeff();
    const Eigen::VectorXd step = damped.ldlt().solve(right);
    BlurredPlace next = at;
    for (Eigen::Index k = 0; k < n_terms; ++k) {
      next.place.u[static_cast<std::size_t>(k)] += step[k];
      next.place.v[static_cast<std::size_t>(k)] += step[n_terms + k];
    }
    const Eigen::VectorXd rest = step.tail(6);
    next.sigma2_u = std::clamp(at.sigma2_u + rest[0], 0.05, 16.0);
    next.sigma2_v = std::clamp(at.sigma2_v + rest[1], 0.05, 16.0);
    next.dark += rest[2];
    next.contrast += rest[3];
    next.light_x = std::clamp(at.light_x + rest[4], -0.9, 0.9);
    next.light_y = std::clamp(at.light_y + rest[5], -0.9, 0.9);
    if (!step.allFinite() || step.head(2 * n_terms).cwiseAbs().maxCoeff() > 4) {
      damping = std::max(1e-3, damping * 10);
      if (damping > 1e4) break;
      continue;
    }
    const auto [now, same] = gather(next, false);
    if (!(now < misfit)) {
      damping = std::max(1e-3, damping * 10);
      if (damping > 1e4) break;
      continue;
    }
    const bool done = misfit - now < 1e-7 * misfit;
    at = next;
    misfit = now;
    damping *= 0.1;
    if (done) break;
    gather(at, true);
  }
  at.explained = variance > 0 ? 1 - misfit / variance : 0;
}

}  // namespace

Vec2 PlaceInTarget::at(const Terms& terms) const {
  Vec2 out{0, 0};
  for (std::size_t k = 0; k < terms.size(); ++k) {
    out.x += u[k] * terms[k];
    out.y += v[k] * terms[k];
  }
  return out;
}

std::optional<BlurredPlace> find_place(const UsedPart& part, const RandomCells& cells,
                                       const BlurredPlace* near) {
  const int whole = part.samples.width();
  BlurredPlace at;
  if (near != nullptr) {
    at = *near;
  } else {
    const LikelyPlace best = search_target(part, cells, kFirstSigma_px);
    const double half = part.half_px();
    at.place.u = {best.middle.x, best.turn.a * half, best.turn.b * half};
    at.place.v = {best.middle.y, best.turn.c * half, best.turn.d * half};
    at.sigma2_u = at.sigma2_v = kFirstSigma_px * kFirstSigma_px;
    // Levels are linear: any start will do, but the first steps should not move the place for them.
    double sum = 0, squares = 0, count = 0;
    for (int y = 0; y < whole; ++y) {
      for (int x = 0; x < whole; ++x) {
        const double v = static_cast<double>(part.samples(x, y));
        if (!std::isfinite(v)) continue;
        sum += v;
        squares += v * v;
        count += 1;
      }
    }
    if (count < 64) return std::nullopt;
    const double mean = sum / count;
    at.contrast = 4 * std::sqrt(std::max(0.0, squares / count - mean * mean));
    at.dark = mean - 0.5 * at.contrast;
    refine(part, cells, kSearchSide_px, false, at);
    if (!(at.explained > kLooksLike)) return std::nullopt;
  }
  // From the middle outwards, so that a wrong scale or turn never costs more than part of a cell.
  for (const int side : kSides) {
    if (side >= whole || near != nullptr) break;
    refine(part, cells, side, false, at);
  }
  refine(part, cells, whole, false, at);
  refine(part, cells, whole, true, at);
  if (!(at.explained > kIsTarget) || !(at.contrast > 0)) return std::nullopt;
  return at;
}

}  // namespace reseau::random_target
