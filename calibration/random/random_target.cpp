#include "calibration/random/random_target.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include "calibration/random/spline_cells.h"

namespace reseau {
namespace {

using random_target::cubic_spline;
using random_target::SplineCells;

constexpr int kLeastSide = 40;       // px of the picture
constexpr double kFullRank = 1e-7;   // smallest eigenvalue of the curvature over the largest
constexpr double kAside_px = 0.02;   // step of numerical derivatives
constexpr double kFirstSigma = 0.7;  // of the spread that the search supposes

// Where pixels lie in the target: about the middle of the part that is used.
struct Place {
  Vec2 middle;  // of the part [px of the picture]
  Vec2 origin;  // of the middle, in the target
  Mat2 scale;
  [[nodiscard]] Vec2 of(double x, double y) const {
    return origin + scale * Vec2{x - middle.x, y - middle.y};
  }
};

struct Part {
  Span2D<const float> samples;
  int x0 = 0, y0 = 0, side_x = 0, side_y = 0;
};

Part part_in_the_middle(Span2D<const float> samples, int most) {
  Part out{samples, 0, 0, std::min(most, samples.width()), std::min(most, samples.height())};
  out.x0 = (samples.width() - out.side_x) / 2;
  out.y0 = (samples.height() - out.side_y) / 2;
  return out;
}

// A target under a Gaussian, as a knot's own weights.
std::vector<double> gaussian_knots(int n, double step_px) {
  std::vector<double> out;
  double sum = 0;
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      const double r2 = std::pow((x - n / 2) * step_px, 2) + std::pow((y - n / 2) * step_px, 2);
      out.push_back(std::exp(-r2 / (2 * kFirstSigma * kFirstSigma)));
      sum += out.back();
    }
  }
  for (double& v : out) v /= sum;
  return out;
}

// The shift within the search at which the picture looks most like the target.
Vec2 search(const Part& part, const SplineCells& cells, const std::vector<double>& knots,
            const Place& start, int reach) {
  constexpr int kSide = 40;
  const int half = kSide / 2;
  const auto cx = static_cast<int>(std::lround(start.middle.x));
  const auto cy = static_cast<int>(std::lround(start.middle.y));
  std::vector<double> row(knots.size());
  // The target, as blurred, on every half pixel around.
  const int wide = 2 * (kSide + 2 * reach) + 1;
  std::vector<double> seen;
  for (int j = 0; j < wide; ++j) {
    for (int i = 0; i < wide; ++i) {
      const Vec2 at = start.of(cx - half - reach + i * 0.5, cy - half - reach + j * 0.5);
      cells.features(at.x, at.y, row);
      double v = 0;
      for (std::size_t k = 0; k < knots.size(); ++k) v += row[k] * knots[k];
      seen.push_back(v);
    }
  }
  double best = -2;
  Vec2 shift{0, 0};
  for (int dy = 0; dy <= 4 * reach; ++dy) {
    for (int dx = 0; dx <= 4 * reach; ++dx) {
      double n = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
      for (int y = 0; y < kSide; y += 2) {
        for (int x = 0; x < kSide; x += 2) {
          const int px = cx - half + x, py = cy - half + y;
          if (px < 0 || py < 0 || px >= part.samples.width() || py >= part.samples.height())
            continue;
          const double u = double{part.samples(px, py)};
          const double v = seen[static_cast<std::size_t>((2 * y + dy) * wide + 2 * x + dx)];
          if (!std::isfinite(u)) continue;
          n += 1;
          a += u;
          b += v;
          aa += u * u;
          bb += v * v;
          ab += u * v;
        }
      }
      const double r =
          (n * ab - a * b) / std::sqrt(std::max(1e-30, (n * aa - a * a) * (n * bb - b * b)));
      if (r <= best) continue;
      best = r;
      shift = {dx * 0.5 - reach, dy * 0.5 - reach};
    }
  }
  return shift;
}

struct Normal {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd right;
  double squares = 0, n = 0;
};

// Sums over a square of `side` px about the middle: knots, a constant, and, with knots known, the
// six numbers of the place (origin, scale).
Normal gather(const Part& part, const SplineCells& cells, const Place& place, int side,
              const Eigen::VectorXd* solution, std::size_t n_knots2, bool with_place) {
  const auto n_linear = static_cast<Eigen::Index>(n_knots2) + 1;
  const Eigen::Index n = n_linear + (with_place ? 6 : 0);
  Normal out{Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd::Zero(n), 0, 0};
  constexpr int kBlock = 64;
  Eigen::MatrixXd rows(kBlock, n);
  Eigen::VectorXd values(kBlock);
  int filled = 0;
  const auto flush = [&] {
    if (filled == 0) return;
    out.matrix.selfadjointView<Eigen::Lower>().rankUpdate(rows.topRows(filled).transpose());
    out.right += rows.topRows(filled).transpose() * values.head(filled);
    out.squares += values.head(filled).squaredNorm();
    out.n += filled;
    filled = 0;
  };
  std::vector<double> seen(n_knots2);
  const auto model_at = [&](Vec2 at) {
    cells.features(at.x, at.y, seen);
    double v = 0;
    for (std::size_t k = 0; k < n_knots2; ++k)
      v += seen[k] * (*solution)[static_cast<Eigen::Index>(k)];
    return v;
  };
  const auto x_first = static_cast<int>(std::max<double>(part.x0, place.middle.x - side / 2.0));
  const auto y_first = static_cast<int>(std::max<double>(part.y0, place.middle.y - side / 2.0));
  for (int y = y_first; y < std::min(part.y0 + part.side_y, y_first + side); ++y) {
    for (int x = x_first; x < std::min(part.x0 + part.side_x, x_first + side); ++x) {
      const double value = double{part.samples(x, y)};
      if (!std::isfinite(value)) continue;
      const Vec2 at = place.of(x, y);
      double rest = value;
      if (with_place) {
        const double here = model_at(at);
        const double gx = (model_at({at.x + kAside_px, at.y}) - here) / kAside_px;
        const double gy = (model_at({at.x, at.y + kAside_px}) - here) / kAside_px;
        const double dx = x - place.middle.x, dy = y - place.middle.y;
        const std::array<double, 6> by{gx, gy, gx * dx, gx * dy, gy * dx, gy * dy};
        for (std::size_t k = 0; k < by.size(); ++k) {
          rows(filled, n_linear + static_cast<Eigen::Index>(k)) = by[k];
        }
        rest -= here + (*solution)[n_linear - 1];
      }
      cells.features(at.x, at.y, seen);
      for (std::size_t k = 0; k < n_knots2; ++k)
        rows(filled, static_cast<Eigen::Index>(k)) = seen[k];
      rows(filled, n_linear - 1) = 1;
      values[filled] = rest;
      if (++filled == kBlock) flush();
    }
  }
  flush();
  out.matrix = out.matrix.selfadjointView<Eigen::Lower>();
  return out;
}

void fill(const Eigen::VectorXd& knots, const Eigen::MatrixXd& covariance, int n, RandomPsf& out) {
  // Samples of the spline at its knots.
  const auto nn = static_cast<Eigen::Index>(n);
  Eigen::MatrixXd along(nn, nn);
  for (Eigen::Index i = 0; i < nn; ++i) {
    for (Eigen::Index k = 0; k < nn; ++k) {
      along(i, k) = cubic_spline(static_cast<double>(i - k)) / out.step_px;
    }
  }
  const double sum = knots.head(nn * nn).sum();
  double variances = 0, squares = 0;
  for (Eigen::Index y = 0; y < nn; ++y) {
    for (Eigen::Index x = 0; x < nn; ++x) {
      Eigen::VectorXd weight = Eigen::VectorXd::Zero(nn * nn);
      for (Eigen::Index j = std::max<Eigen::Index>(0, y - 1); j <= std::min(nn - 1, y + 1); ++j) {
        for (Eigen::Index i = std::max<Eigen::Index>(0, x - 1); i <= std::min(nn - 1, x + 1); ++i) {
          weight[j * nn + i] = along(y, j) * along(x, i) / sum;
        }
      }
      const double value = weight.dot(knots.head(nn * nn));
      // The sum is known as well as the contrast; its own error is left out beside the value's.
      const double variance = weight.dot(covariance.topLeftCorner(nn * nn, nn * nn) * weight);
      out.psf.push_back(value);
      out.sd.push_back(std::sqrt(std::max(0.0, variance)));
      variances += std::max(0.0, variance);
      squares += value * value;
    }
  }
  out.sd_of_all = std::sqrt(variances / squares);
}

}  // namespace

bool random_cell(std::uint64_t seed, std::int64_t column, std::int64_t row) {
  std::uint64_t z = seed * 0x9E3779B97F4A7C15ULL +
                    static_cast<std::uint64_t>(column) * 0xD1B54A32D192ED03ULL +
                    static_cast<std::uint64_t>(row) * 0x8CB92BA72F3D8DD7ULL;
  for (int round = 0; round < 2; ++round) {
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    z ^= z >> 31;
  }
  return (z >> 63) != 0;
}

double RandomPsf::mtf(double fx, double fy) const {
  std::complex<double> sum;
  const int half = side / 2;
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const double phase = -2 * std::numbers::pi * step_px * (fx * (x - half) + fy * (y - half));
      sum += psf[static_cast<std::size_t>(y * side + x)] * std::polar(1.0, phase);
    }
  }
  return std::abs(sum) * step_px * step_px;
}

RandomPsf measure_random(Span2D<const float> samples, const RandomTarget& target,
                         const RandomOptions& options) {
  RandomPsf out;
  const int n = options.support_px * options.per_px / 2 * 2 + 1;
  out.step_px = 1.0 / options.per_px;
  const auto n2 = static_cast<std::size_t>(n) * static_cast<std::size_t>(n);
  if (std::min(samples.width(), samples.height()) < kLeastSide) {
    out.why = "The picture of the random target is smaller than 40 pixels.";
    return out;
  }
  const Part part = part_in_the_middle(samples, options.most_px);
  Place place;
  place.middle = {part.x0 + (part.side_x - 1) / 2.0, part.y0 + (part.side_y - 1) / 2.0};
  place.origin = options.start_px + place.middle;
  const SplineCells cells(target, n, out.step_px);
  std::vector<double> knots = gaussian_knots(n, out.step_px);
  place.origin =
      place.origin + search(part, cells, knots, place, std::clamp(options.search_px, 1, 64));

  // From the middle outwards, so that a wrong scale or turn never costs more than half a cell.
  Eigen::VectorXd solution = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(n2) + 1);
  const int whole = std::max(part.side_x, part.side_y);
  Normal normal;
  const auto n_linear = static_cast<Eigen::Index>(n2) + 1;
  for (const int side : {std::min(36, whole), std::min(64, whole), whole, whole}) {
    for (int round = 0; round < 3; ++round) {
      normal = gather(part, cells, place, side, nullptr, n2, false);
      // A little weight towards nothing until the whole part is in, which has more samples than
      // knots by far.
      if (side < whole) {
        normal.matrix.diagonal().array() += 1e-3 * normal.matrix.diagonal().maxCoeff();
      }
      solution = normal.matrix.ldlt().solve(normal.right);
      const Normal moved = gather(part, cells, place, side, &solution, n2, true);
      // Knots answer for a shift as well: that is taken as theirs, scale and turn are the place's.
      Eigen::MatrixXd free = moved.matrix.bottomRightCorner(6, 6);
      const Eigen::VectorXd step = free.ldlt().solve(moved.right.tail(6));
      place.origin = {place.origin.x + step[0], place.origin.y + step[1]};
      place.scale = {place.scale.a + step[2], place.scale.b + step[3], place.scale.c + step[4],
                     place.scale.d + step[5]};
      if (step.head(2).norm() < 1e-4 && step.tail(4).norm() * side < 1e-4) break;
    }
  }
  normal = gather(part, cells, place, whole, nullptr, n2, false);
  solution = normal.matrix.ldlt().solve(normal.right);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
      normal.matrix.topLeftCorner(n_linear - 1, n_linear - 1), Eigen::EigenvaluesOnly);
  out.smallest_share = eigen.eigenvalues().minCoeff() / eigen.eigenvalues().maxCoeff();
  if (!(out.smallest_share > kFullRank)) {
    out.why =
        "The cells of the target repeat the pixels, so that the spread cannot be told. Use cells "
        "of another size, or turn the target.";
    return out;
  }
  const double contrast = solution.head(n_linear - 1).sum();
  const double left = std::max(1.0, normal.n - static_cast<double>(n_linear) - 6);
  const double rest =
      normal.squares - 2 * solution.dot(normal.right) + solution.dot(normal.matrix * solution);
  const double variance = std::max(0.0, rest) / left;
  if (!(contrast > 0) || !(contrast * contrast > variance) || !place.scale.determinant()) {
    out.why = "The picture does not look like the random target of this seed and cell size.";
    return out;
  }
  const Normal joint = gather(part, cells, place, whole, &solution, n2, true);
  // Of knots, level and scale; a shift is the knots' own.
  Eigen::MatrixXd curvature(n_linear + 4, n_linear + 4);
  curvature.topLeftCorner(n_linear, n_linear) = joint.matrix.topLeftCorner(n_linear, n_linear);
  curvature.bottomLeftCorner(4, n_linear) = joint.matrix.bottomLeftCorner(4, n_linear);
  curvature.topRightCorner(n_linear, 4) = joint.matrix.topRightCorner(n_linear, 4);
  curvature.bottomRightCorner(4, 4) = joint.matrix.bottomRightCorner(4, 4);
  const Eigen::MatrixXd covariance =
      variance * curvature.ldlt().solve(Eigen::MatrixXd::Identity(n_linear + 4, n_linear + 4));
  out.side = n;
  out.dark = solution[n_linear - 1];
  out.contrast = contrast;
  out.noise = std::sqrt(variance) / contrast;
  fill(solution, covariance, n, out);
  // The middle of the spread is the target's place.
  Eigen::VectorXd by_x = Eigen::VectorXd::Zero(n_linear + 4), by_y = by_x;
  Vec2 middle{0, 0};
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      const auto k = static_cast<Eigen::Index>(y * n + x);
      middle.x += solution[k] * (x - n / 2) * out.step_px / contrast;
      middle.y += solution[k] * (y - n / 2) * out.step_px / contrast;
    }
  }
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      const auto k = static_cast<Eigen::Index>(y * n + x);
      by_x[k] = ((x - n / 2) * out.step_px - middle.x) / contrast;
      by_y[k] = ((y - n / 2) * out.step_px - middle.y) / contrast;
    }
  }
  const Vec2 first = place.of(0, 0);
  out.origin_px = {first.x - middle.x, first.y - middle.y};
  out.origin_sd_px = {std::sqrt(std::max(0.0, by_x.dot(covariance * by_x))),
                      std::sqrt(std::max(0.0, by_y.dot(covariance * by_y)))};
  out.scale = place.scale;
  out.ok = true;
  return out;
}

}  // namespace reseau
