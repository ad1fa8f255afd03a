#include "calibration/random/spread_prior.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "calibration/random/spline_cells.h"

namespace reseau::random_target {
namespace {

constexpr double kTaper = 2, kFloor = 0.1;  // sigmas over which the rest fades; what is left of it

// Of the rest: smooth over `length` sigmas, large in the middle.
Eigen::MatrixXd kernel(int n_knots, double step_px, double sigma2_u, double sigma2_v,
                       double length) {
  const Eigen::Index n = n_knots, n2 = n * n;
  Eigen::MatrixXd out(n2, n2);
  const auto taper = [&](Eigen::Index k) {
    const double u = from_middle(k % n, n) * step_px;
    const double v = from_middle(k / n, n) * step_px;
    return kFloor + std::exp(-(u * u / sigma2_u + v * v / sigma2_v) / (2 * kTaper * kTaper));
  };
  for (Eigen::Index a = 0; a < n2; ++a) {
    for (Eigen::Index b = 0; b <= a; ++b) {
      const double u = static_cast<double>(a % n - b % n) * step_px;
      const Eigen::Index rows = a / n - b / n;
      const double v = static_cast<double>(rows) * step_px;
      out(a, b) = taper(a) * taper(b) *
                  std::exp(-(u * u / sigma2_u + v * v / sigma2_v) / (2 * length * length));
      out(b, a) = out(a, b);
    }
  }
  out.diagonal() *= 1 + 1e-6;
  return out;
}

// The system with the contrast's column before the others'.
struct Split {
  Eigen::MatrixXd rest, across, others;  // blocks
  Eigen::VectorXd right_rest, right_others;
};
Split split(const SpreadSystem& s) {
  const Eigen::Index n2 = s.gaussian.size(), n_others = s.right.size() - n2;
  Split out;
  out.rest = s.matrix.topLeftCorner(n2, n2);
  out.across.resize(n2, n_others + 1);
  out.across.col(0) = out.rest * s.gaussian;
  out.across.rightCols(n_others) = s.matrix.topRightCorner(n2, n_others);
  out.others.resize(n_others + 1, n_others + 1);
  out.others(0, 0) = s.gaussian.dot(out.across.col(0));
  out.others.block(1, 0, n_others, 1) = s.matrix.bottomLeftCorner(n_others, n2) * s.gaussian;
  out.others.block(0, 1, 1, n_others) = out.others.block(1, 0, n_others, 1).transpose();
  out.others.bottomRightCorner(n_others, n_others) = s.matrix.bottomRightCorner(n_others, n_others);
  out.right_rest = s.right.head(n2);
  out.right_others.resize(n_others + 1);
  out.right_others[0] = s.gaussian.dot(out.right_rest);
  out.right_others.tail(n_others) = s.right.tail(n_others);
  return out;
}

}  // namespace

SpreadPrior::SpreadPrior(const SpreadSystem& system, int n_knots, double step_px, double sigma2_u,
                         double sigma2_v) {
  const Split s = split(system);
  const Eigen::LDLT<Eigen::MatrixXd> others(s.others);
  const Eigen::MatrixXd data = s.rest - s.across * others.solve(s.across.transpose());
  const Eigen::VectorXd right = s.right_rest - s.across * others.solve(s.right_others);
  // As if the rest were none at present.
  const Eigen::VectorXd whole = right + data * system.rest;
  const double left = system.squares - s.right_others.dot(others.solve(s.right_others)) +
                      system.rest.dot(2 * right + data * system.rest);
  const double freedom = std::max(1.0, system.n - static_cast<double>(s.right_others.size()));
  double best = std::numeric_limits<double>::infinity();
  for (const double length : {0.5, 0.75, 1.0}) {
    const Eigen::MatrixXd c = kernel(n_knots, step_px, sigma2_u, sigma2_v, length);
    const Eigen::LLT<Eigen::MatrixXd> root(c);
    if (root.info() != Eigen::Success) continue;
    const Eigen::MatrixXd l = root.matrixL();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(l.transpose() * data * l);
    const Eigen::VectorXd q = eigen.eigenvectors().transpose() * (l.transpose() * whole);
    for (int step = -40; step <= 40; ++step) {
      const double size = std::pow(10.0, 0.25 * step);
      double rest = left, logs = 0;
      for (Eigen::Index k = 0; k < q.size(); ++k) {
        const double with = 1 + size * std::max(0.0, eigen.eigenvalues()[k]);
        rest -= size * q[k] * q[k] / with;
        logs += std::log(with);
      }
      if (!(rest > 0)) continue;
      const double cost = freedom * std::log(rest) + logs;
      if (!(cost < best)) continue;
      best = cost;
      length_ = length;
      precision_ = root.solve(Eigen::MatrixXd::Identity(c.rows(), c.rows())) / size;
    }
  }
}

SpreadStep SpreadPrior::solve(const SpreadSystem& system, bool with_covariance) const {
  const Split s = split(system);
  const Eigen::Index n2 = s.rest.rows(), n = n2 + s.others.rows();
  Eigen::MatrixXd all(n, n);
  all.topLeftCorner(n2, n2) = s.rest + precision_;
  all.topRightCorner(n2, n - n2) = s.across;
  all.bottomLeftCorner(n - n2, n2) = s.across.transpose();
  all.bottomRightCorner(n - n2, n - n2) = s.others;
  Eigen::VectorXd right(n);
  right << s.right_rest - precision_ * system.rest, s.right_others;
  const Eigen::LDLT<Eigen::MatrixXd> solver(all);
  const Eigen::VectorXd step = solver.solve(right);
  SpreadStep out;
  out.rest = system.rest + step.head(n2);
  out.contrast = step[n2];
  out.others = step.tail(n - n2 - 1);
  // What the penalised sum comes down to, over the samples less what is free.
  const double penalised =
      system.squares + system.rest.dot(precision_ * system.rest) - step.dot(right);
  out.variance = std::max(0.0, penalised) /
                 std::max(1.0, system.n - static_cast<double>(s.right_others.size()));
  if (with_covariance) {
    Eigen::MatrixXd to_knots = Eigen::MatrixXd::Zero(n, n2);
    to_knots.topRows(n2).setIdentity();
    to_knots.row(n2) = system.gaussian.transpose();
    out.covariance = out.variance * (to_knots.transpose() * solver.solve(to_knots));
  }
  return out;
}

double weakest_in_band(const Eigen::MatrixXd& by_knots, int n_knots, double step_px) {
  constexpr double kBand = 0.75;  // cycles/px
  const Eigen::Index n = n_knots;
  Eigen::MatrixXd band(n, n);
  for (Eigen::Index a = 0; a < n; ++a) {
    for (Eigen::Index b = 0; b < n; ++b) {
      const double x = 2 * kBand * step_px * static_cast<double>(a - b);
      band(a, b) =
          a == b ? 2 * kBand * step_px
                 : 2 * kBand * step_px * std::sin(std::numbers::pi * x) / (std::numbers::pi * x);
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> slepian(band);
  Eigen::Index first = 0;
  while (first + 1 < n && slepian.eigenvalues()[first] < 0.5) ++first;
  const Eigen::Index m = n - first;
  const Eigen::MatrixXd along = slepian.eigenvectors().rightCols(m);
  Eigen::MatrixXd patterns(n * n, m * m);
  for (Eigen::Index a = 0; a < m; ++a) {
    for (Eigen::Index b = 0; b < m; ++b) {
      for (Eigen::Index j = 0; j < n; ++j) {
        patterns.block(j * n, a * m + b, n, 1) = along(j, a) * along.col(b);
      }
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
      patterns.transpose() * by_knots * patterns, Eigen::EigenvaluesOnly);
  return eigen.eigenvalues().minCoeff() / eigen.eigenvalues().maxCoeff();
}

}  // namespace reseau::random_target
