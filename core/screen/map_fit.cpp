#include "core/screen/map_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <tbb/parallel_for.h>

namespace reseau {
namespace {

constexpr int kRobustRounds = 4;
constexpr double kCauchy = 3.0;  // residuals beyond this many sigmas fade

struct Affine {
  Mat2 linear;
  Vec2 offset;
  [[nodiscard]] Vec2 operator()(Vec2 p) const { return linear * p + offset; }
};

struct Weighted {
  std::vector<double> u, v;
};

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Weighted least squares of one coordinate on (x, y, 1), positions scaled for conditioning.
Eigen::Vector3d fit_plane(const std::vector<PhaseSample>& samples,
                          const std::vector<double>& weights, double scale, bool along_u) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Eigen::Vector3d row(samples[i].p_in_scan.x / scale, samples[i].p_in_scan.y / scale, 1);
    const double value = along_u ? samples[i].s_in_screen.x : samples[i].s_in_screen.y;
    normal += weights[i] * row * row.transpose();
    right += weights[i] * value * row;
  }
  normal += Eigen::Matrix3d::Identity() * (1e-12 * normal.trace());
  Eigen::Vector3d plane = normal.ldlt().solve(right);
  plane(0) /= scale;
  plane(1) /= scale;
  return plane;
}

Affine fit_affine(const std::vector<PhaseSample>& samples, const Weighted& weights, double scale) {
  const Eigen::Vector3d u = fit_plane(samples, weights.u, scale, true);
  const Eigen::Vector3d v = fit_plane(samples, weights.v, scale, false);
  return {{u(0), u(1), v(0), v(1)}, {u(2), v(2)}};
}

// Multiplies the information of each sample by a Cauchy weight of its residual.
Weighted robust_weights(const std::vector<PhaseSample>& samples,
                        const std::vector<Vec2>& residuals) {
  Weighted weights;
  for (const bool along_u : {true, false}) {
    std::vector<double> normalised;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double info = along_u ? samples[i].info_u : samples[i].info_v;
      const double r = along_u ? residuals[i].x : residuals[i].y;
      if (info > 0) normalised.push_back(std::abs(r) * std::sqrt(info));
    }
    const double sigma = std::max(1.4826 * median(normalised), 1e-12);
    auto& out = along_u ? weights.u : weights.v;
    out.resize(samples.size());
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double info = along_u ? samples[i].info_u : samples[i].info_v;
      const double r = (along_u ? residuals[i].x : residuals[i].y) * std::sqrt(std::max(info, 0.0));
      const double k = r / (kCauchy * sigma);
      // One sample in full light must not outweigh hundreds: cap what the model error allows.
      constexpr double kMostInfo = 1 / (0.002 * 0.002);
      out[i] = info > 0 ? std::min(info, kMostInfo) / (1 + k * k) : 0.0;
    }
  }
  return weights;
}

// Basis of the displacement: cubic B-splines on a regular grid that covers the frame.
class SplineBasis {
 public:
  SplineBasis(int width_px, int height_px) {
    const double area = static_cast<double>(width_px) * height_px;
    spacing_ = std::max(40.0, std::sqrt(area / 11000));
    n_columns_ = std::max(4, static_cast<int>(std::ceil(width_px / spacing_)) + 3);
    n_rows_ = std::max(4, static_cast<int>(std::ceil(height_px / spacing_)) + 3);
  }
  [[nodiscard]] int size() const { return n_columns_ * n_rows_; }
  [[nodiscard]] int n_columns() const { return n_columns_; }
  [[nodiscard]] int n_rows() const { return n_rows_; }
  [[nodiscard]] double spacing() const { return spacing_; }

  // The 16 basis functions that are not zero at p.
  void at(Vec2 p, std::array<int, 16>& index, std::array<double, 16>& value) const {
    int ix = 0, iy = 0;
    const auto wx = weights(p.x, n_columns_, ix);
    const auto wy = weights(p.y, n_rows_, iy);
    for (int j = 0; j < 4; ++j) {
      for (int i = 0; i < 4; ++i) {
        const auto k = static_cast<std::size_t>(4 * j + i);
        index[k] = (iy + j) * n_columns_ + ix + i;
        value[k] = wx[static_cast<std::size_t>(i)] * wy[static_cast<std::size_t>(j)];
      }
    }
  }

  // Squared second differences along rows, columns and the diagonal pair: the bending of a plate.
  [[nodiscard]] Eigen::SparseMatrix<double> bending() const {
    std::vector<Eigen::Triplet<double>> triplets;
    const auto add = [&](std::initializer_list<std::pair<int, double>> stencil, double weight) {
      for (const auto& [i, a] : stencil) {
        for (const auto& [j, b] : stencil) triplets.emplace_back(i, j, weight * a * b);
      }
    };
    const auto at_ij = [&](int i, int j) { return j * n_columns_ + i; };
    for (int j = 0; j < n_rows_; ++j) {
      for (int i = 0; i < n_columns_; ++i) {
        if (i + 2 < n_columns_)
          add({{at_ij(i, j), 1}, {at_ij(i + 1, j), -2}, {at_ij(i + 2, j), 1}}, 1);
        if (j + 2 < n_rows_)
          add({{at_ij(i, j), 1}, {at_ij(i, j + 1), -2}, {at_ij(i, j + 2), 1}}, 1);
        if (i + 1 < n_columns_ && j + 1 < n_rows_) {
          add({{at_ij(i, j), 1},
               {at_ij(i + 1, j), -1},
               {at_ij(i, j + 1), -1},
               {at_ij(i + 1, j + 1), 1}},
              2);
        }
      }
    }
    Eigen::SparseMatrix<double> matrix(size(), size());
    matrix.setFromTriplets(triplets.begin(), triplets.end());
    return matrix;
  }

 private:
  std::array<double, 4> weights(double position, int n, int& first) const {
    const double cell = std::clamp(position / spacing_, 0.0, n - 3.0);
    first = std::min(static_cast<int>(cell), n - 4);
    const double t = cell - first, s = 1 - t;
    return {s * s * s / 6, (3 * t * t * t - 6 * t * t + 4) / 6,
            (-3 * t * t * t + 3 * t * t + 3 * t + 1) / 6, t * t * t / 6};
  }
  double spacing_ = 0;
  int n_columns_ = 0, n_rows_ = 0;
};

Eigen::VectorXd solve_spline(const SplineBasis& basis, const Eigen::SparseMatrix<double>& bending,
                             const std::vector<PhaseSample>& samples,
                             const std::vector<double>& weights, const std::vector<double>& values,
                             double smoothing) {
  std::vector<Eigen::Triplet<double>> triplets;
  triplets.reserve(samples.size() * 136);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(basis.size());
  std::array<int, 16> index{};
  std::array<double, 16> value{};
  double total = 0;
  for (std::size_t s = 0; s < samples.size(); ++s) {
    if (!(weights[s] > 0)) continue;
    total += weights[s];
    basis.at(samples[s].p_in_scan, index, value);
    for (std::size_t i = 0; i < 16; ++i) {
      right(index[i]) += weights[s] * value[i] * values[s];
      for (std::size_t j = 0; j < 16; ++j) {
        if (index[j] <= index[i])
          triplets.emplace_back(index[i], index[j], weights[s] * value[i] * value[j]);
      }
    }
  }
  Eigen::SparseMatrix<double> normal(basis.size(), basis.size());
  normal.setFromTriplets(triplets.begin(), triplets.end());
  const double unit = total / std::max<double>(1, static_cast<double>(samples.size()));
  Eigen::SparseMatrix<double> penalty = (unit * smoothing) * bending;
  // Bending leaves planes free; the affine map has taken them, so a trace of ridge settles them.
  for (int i = 0; i < basis.size(); ++i) penalty.coeffRef(i, i) += 1e-7 * unit * (1 + smoothing);
  normal += penalty.triangularView<Eigen::Lower>();
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower> solver(normal);
  if (solver.info() != Eigen::Success) return Eigen::VectorXd::Zero(basis.size());
  Eigen::VectorXd solution = solver.solve(right);
  if (!solution.allFinite()) solution.setZero();
  return solution;
}

double value_at(const SplineBasis& basis, const Eigen::VectorXd& c, Vec2 p) {
  std::array<int, 16> index{};
  std::array<double, 16> value{};
  basis.at(p, index, value);
  double sum = 0;
  for (std::size_t i = 0; i < 16; ++i) sum += value[i] * c(index[i]);
  return sum;
}

// Blocks large enough that a held-out sample shares no pixel with a fitted one but at the rim.
bool held_out(const PhaseSample& sample, int fold) {
  constexpr double kBlockPx = 130;
  const int i = static_cast<int>(std::floor(sample.p_in_scan.x / kBlockPx));
  const int j = static_cast<int>(std::floor(sample.p_in_scan.y / kBlockPx));
  return (((i + 2 * j) % 5) + 5) % 5 == fold;
}

// Mean loss of held-out samples for a smoothing; infinity = displacement zero.
double held_out_loss(const SplineBasis& basis, const Eigen::SparseMatrix<double>& bending,
                     const std::vector<PhaseSample>& samples, const std::vector<double>& weights,
                     const std::vector<double>& values, double smoothing) {
  double loss = 0;
  for (const int fold : {0, 2}) {
    std::vector<double> kept = weights;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      if (held_out(samples[i], fold)) kept[i] = 0;
    }
    Eigen::VectorXd c;
    if (std::isfinite(smoothing))
      c = solve_spline(basis, bending, samples, kept, values, smoothing);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      if (!held_out(samples[i], fold) || !(weights[i] > 0)) continue;
      const double predicted =
          std::isfinite(smoothing) ? value_at(basis, c, samples[i].p_in_scan) : 0;
      const double r = (values[i] - predicted) * (values[i] - predicted) * weights[i];
      loss += std::log1p(r / 20);  // robust: outliers must not choose the model
    }
  }
  return loss;
}

}  // namespace

MapFit fit_map(const std::vector<PhaseSample>& samples, int width_px, int height_px) {
  MapFit fit;
  if (samples.size() < 6) return fit;
  const double scale = std::max(width_px, height_px);
  std::vector<Vec2> residuals(samples.size());
  Weighted weights = robust_weights(samples, residuals);
  Affine affine;
  // First without any trust in the tails: film that bends leaves large residuals of an affine map,
  // and they are not outliers.
  affine = fit_affine(samples, weights, scale);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    residuals[i] = samples[i].s_in_screen - affine(samples[i].p_in_scan);
  }

  const SplineBasis basis(width_px, height_px);
  const Eigen::SparseMatrix<double> bending = basis.bending();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const std::array<double, 8> choices{kInfinity, 1e5, 1e4, 1e3, 1e2, 10, 1, 0.1};
  Eigen::VectorXd cu, cv;
  double smoothing = kInfinity;
  for (int round = 0; round < kRobustRounds; ++round) {
    if (round <= 1) {
      std::vector<double> u(samples.size()), v(samples.size());
      for (std::size_t i = 0; i < samples.size(); ++i) {
        const Vec2 d = samples[i].s_in_screen - affine(samples[i].p_in_scan);
        u[i] = d.x;
        v[i] = d.y;
      }
      std::array<double, choices.size()> loss{};
      tbb::parallel_for(std::size_t{0}, choices.size(), [&](std::size_t k) {
        loss[k] = held_out_loss(basis, bending, samples, weights.u, u, choices[k]) +
                  held_out_loss(basis, bending, samples, weights.v, v, choices[k]);
      });
      // The stiffest choice that is not clearly worse than the best.
      const double best = *std::min_element(loss.begin(), loss.end());
      for (std::size_t k = 0; k < choices.size(); ++k) {
        if (loss[k] <= best * 1.03 + 1e-12) {
          smoothing = choices[k];
          break;
        }
      }
    }
    if (!std::isfinite(smoothing)) affine = fit_affine(samples, weights, scale);
    std::vector<double> u(samples.size()), v(samples.size());
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const Vec2 d = samples[i].s_in_screen - affine(samples[i].p_in_scan);
      u[i] = d.x;
      v[i] = d.y;
    }
    if (std::isfinite(smoothing)) {
      cu = solve_spline(basis, bending, samples, weights.u, u, smoothing);
      cv = solve_spline(basis, bending, samples, weights.v, v, smoothing);
      for (std::size_t i = 0; i < samples.size(); ++i) {
        residuals[i] = {u[i] - value_at(basis, cu, samples[i].p_in_scan),
                        v[i] - value_at(basis, cv, samples[i].p_in_scan)};
      }
    } else {
      for (std::size_t i = 0; i < samples.size(); ++i) residuals[i] = {u[i], v[i]};
    }
    weights = robust_weights(samples, residuals);
  }

  if (std::isfinite(smoothing)) {
    std::vector<Vec2> coefficients(static_cast<std::size_t>(basis.size()));
    for (int i = 0; i < basis.size(); ++i)
      coefficients[static_cast<std::size_t>(i)] = {cu(i), cv(i)};
    fit.map = ScreenMap(affine.linear, affine.offset, basis.spacing(), basis.n_columns(),
                        basis.n_rows(), std::move(coefficients));
  } else {
    fit.map = ScreenMap(affine.linear, affine.offset);
  }
  fit.smoothing = smoothing;
  double sum = 0, sum_weights = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double ratio =
        samples[i].info_u > 0 ? weights.u[i] / std::min(samples[i].info_u, 1 / (0.002 * 0.002)) : 1;
    if (ratio < 0.3) {
      ++fit.n_outliers;
      continue;
    }
    ++fit.n_used;
    const Mat2 inverse = fit.map.jacobian(samples[i].p_in_scan).inverse();
    const Vec2 px = inverse * residuals[i];
    const double weight = std::min(samples[i].info_u, samples[i].info_v);
    sum += weight * dot(px, px);
    sum_weights += weight;
  }
  fit.residual_px = sum_weights > 0 ? std::sqrt(sum / sum_weights) : 0;
  fit.usable = affine.linear.determinant() != 0 && std::isfinite(fit.residual_px);
  return fit;
}

}  // namespace reseau
