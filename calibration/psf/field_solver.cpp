#include "calibration/psf/field_solver.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <ceres/cost_function.h>

#include "core/base/parallel.h"

namespace reseau::psf {
namespace {

constexpr int kMostSteps = 40;
// Chi-squared that no longer matters.
constexpr double kSettled = 1e-3;
// Scaled to a unit diagonal, curvatures below this share of the largest are none.
constexpr double kNoCurvature = 1e-10;

using Shared = Eigen::Matrix<double, kSharedBlocks, 1>;

// As the costs of an edge take them.
std::array<const double*, kBlocks> blocks_of(const std::array<double, kSharedBlocks>& shared,
                                             const double* own) {
  std::array<const double*, kBlocks> blocks{};
  for (std::size_t b = 0; b < kSharedBlocks; ++b) blocks[b] = &shared[b];
  for (std::size_t b = 0; b < 3; ++b) blocks[kSharedBlocks + b] = own + b;
  return blocks;
}

}  // namespace

// Of one edge, its own unknowns eliminated.
struct FieldSolver::Terms {
  bool ok = false;
  Eigen::Matrix<double, kSharedBlocks, kSharedBlocks> h;
  Shared g;
  Eigen::Matrix3d own_inverse;
  Eigen::Matrix<double, 3, kSharedBlocks> across;
  Eigen::Vector3d own_g;
};

Eigen::Index FieldState::size() const {
  Eigen::Index n = 0;
  for (const FieldSurface& s : surfaces) n += terms_of(s.order);
  return n;
}

FieldSolver::FieldSolver(std::span<const PsfEdge> edges, std::span<const Vec2> places,
                         bool has_focus, const std::array<double, kSharedBlocks>& fixed)
    : edges_(edges), fixed_(fixed) {
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const double x = places[e].x, y = places[e].y;
    basis_.emplace_back();
    basis_.back() << 1, x, y, x * x, x * y, y * y;
    const double waves =
        has_focus ? 1 / kPsfWavelengths_um[static_cast<std::size_t>(edges[e].channel)] : 1;
    costs_.push_back(edge_cost(edges[e], has_focus ? *edges[e].focus : 0, waves));
  }
}

FieldSolver::~FieldSolver() = default;

bool FieldSolver::applies(const FieldSurface& surface, std::size_t edge) const {
  return surface.channel < 0 || surface.channel == edges_[edge].channel;
}

std::array<double, kSharedBlocks> FieldSolver::local(const FieldState& state,
                                                     std::size_t edge) const {
  std::array<double, kSharedBlocks> out = fixed_;
  for (const FieldSurface& s : state.surfaces) {
    if (applies(s, edge)) out[static_cast<std::size_t>(s.block)] = s.c.dot(basis_[edge]);
  }
  return out;
}

double FieldSolver::chi2_of(const FieldState& state) const {
  std::vector<double> sums(edges_.size());
  parallel_for(static_cast<int>(edges_.size()), [&](int i) {
    const auto e = static_cast<std::size_t>(i);
    const std::array<double, kSharedBlocks> shared = local(state, e);
    const auto blocks = blocks_of(shared, state.own[e].data());
    std::vector<double> residuals(edges_[e].bins.size());
    const bool ok = costs_[e]->Evaluate(blocks.data(), residuals.data(), nullptr);
    sums[e] = ok ? Eigen::Map<const Eigen::VectorXd>(residuals.data(),
                                                     static_cast<Eigen::Index>(residuals.size()))
                       .squaredNorm()
                 : INFINITY;
  });
  double sum = 0;
  for (const double s : sums) sum += s;
  return sum;
}

std::vector<FieldSolver::Terms> FieldSolver::linearise(const FieldState& state) const {
  std::vector<Terms> out(edges_.size());
  parallel_for(static_cast<int>(edges_.size()), [&](int i) {
    const auto e = static_cast<std::size_t>(i);
    const std::array<double, kSharedBlocks> shared = local(state, e);
    const auto blocks = blocks_of(shared, state.own[e].data());
    const auto n = static_cast<Eigen::Index>(edges_[e].bins.size());
    Eigen::VectorXd residuals(n);
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(n, kBlocks);
    std::array<double*, kBlocks> columns{};
    for (std::size_t b = 0; b < kBlocks; ++b) {
      bool wanted = b >= kSharedBlocks;
      for (const FieldSurface& s : state.surfaces) {
        wanted = wanted || (applies(s, e) && s.block == static_cast<Block>(b));
      }
      if (wanted) columns[b] = jacobian.col(static_cast<Eigen::Index>(b)).data();
    }
    Terms& t = out[e];
    t.ok = costs_[e]->Evaluate(blocks.data(), residuals.data(), columns.data());
    if (!t.ok) return;
    const Eigen::MatrixXd full = jacobian.transpose() * jacobian;
    const Eigen::VectorXd slope = jacobian.transpose() * residuals;
    t.own_inverse = Eigen::Matrix3d(full.bottomRightCorner<3, 3>()).inverse();
    t.across = full.bottomLeftCorner<3, kSharedBlocks>();
    t.own_g = slope.tail<3>();
    t.h = full.topLeftCorner<kSharedBlocks, kSharedBlocks>() -
          t.across.transpose() * t.own_inverse * t.across;
    t.g = slope.head<kSharedBlocks>() - t.across.transpose() * t.own_inverse * t.own_g;
    t.ok = t.h.allFinite() && t.g.allFinite();
  });
  return out;
}

FieldNormal FieldSolver::gather(const FieldState& state, const std::vector<Terms>& terms) const {
  FieldNormal out;
  const auto n = static_cast<Eigen::Index>(6 * state.surfaces.size());
  out.a = Eigen::MatrixXd::Zero(n, n);
  out.g = Eigen::VectorXd::Zero(n);
  for (std::size_t e = 0; e < terms.size(); ++e) {
    const Terms& t = terms[e];
    if (!t.ok) return out;
    const Eigen::Matrix<double, 6, 1>& b = basis_[e];
    const Eigen::Matrix<double, 6, 6> square = b * b.transpose();
    for (std::size_t i = 0; i < state.surfaces.size(); ++i) {
      if (!applies(state.surfaces[i], e)) continue;
      const auto row = static_cast<Eigen::Index>(6 * i);
      out.g.segment<6>(row) += b * t.g[state.surfaces[i].block];
      for (std::size_t k = 0; k < state.surfaces.size(); ++k) {
        if (!applies(state.surfaces[k], e)) continue;
        out.a.block<6, 6>(row, static_cast<Eigen::Index>(6 * k)) +=
            t.h(state.surfaces[i].block, state.surfaces[k].block) * square;
      }
    }
    Shared scale;
    for (Eigen::Index k = 0; k < kSharedBlocks; ++k) {
      scale[k] = t.h(k, k) > 0 ? 1 / std::sqrt(t.h(k, k)) : 0;
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, kSharedBlocks, kSharedBlocks>> eigen(
        scale.asDiagonal() * t.h * scale.asDiagonal());
    const Shared turned = eigen.eigenvectors().transpose() * (scale.asDiagonal() * t.g);
    for (Eigen::Index k = 0; k < kSharedBlocks; ++k) {
      if (!(eigen.eigenvalues()[k] > kNoCurvature * eigen.eigenvalues().maxCoeff())) continue;
      out.apart += turned[k] * turned[k] / eigen.eigenvalues()[k];
      out.n_apart += 1;
    }
  }
  out.ok = true;
  return out;
}

FieldNormal FieldSolver::normal(const FieldState& state) const {
  return gather(state, linearise(state));
}

std::vector<Eigen::Index> FieldSolver::free_of(const FieldState& state) {
  std::vector<Eigen::Index> out;
  for (std::size_t i = 0; i < state.surfaces.size(); ++i) {
    for (Eigen::Index k = 0; k < terms_of(state.surfaces[i].order); ++k) {
      out.push_back(static_cast<Eigen::Index>(6 * i) + k);
    }
  }
  return out;
}

bool FieldSolver::solve(FieldState& state, const std::function<bool()>& stop) const {
  state.chi2 = chi2_of(state);
  if (!std::isfinite(state.chi2)) return false;
  const std::vector<Eigen::Index> free = free_of(state);
  double damping = 1e-4;
  std::vector<Terms> terms = linearise(state);
  FieldNormal at = gather(state, terms);
  for (int step = 0; step < kMostSteps && at.ok; ++step) {
    if (stop && stop()) return false;
    Eigen::MatrixXd a = at.a(free, free);
    const Eigen::VectorXd g = at.g(free);
    for (Eigen::Index i = 0; i < a.rows(); ++i) a(i, i) += damping * a(i, i) + 1e-12;
    const Eigen::VectorXd move = -a.ldlt().solve(g);
    FieldState next = state;
    for (std::size_t i = 0; i < free.size(); ++i) {
      next.surfaces[static_cast<std::size_t>(free[i] / 6)].c[free[i] % 6] +=
          move[static_cast<Eigen::Index>(i)];
    }
    for (std::size_t e = 0; e < terms.size(); ++e) {
      Shared moved = Shared::Zero();
      for (std::size_t s = 0; s < state.surfaces.size(); ++s) {
        if (!applies(state.surfaces[s], e)) continue;
        moved[state.surfaces[s].block] += (next.surfaces[s].c - state.surfaces[s].c).dot(basis_[e]);
      }
      next.own[e] -= terms[e].own_inverse * (terms[e].own_g + terms[e].across * moved);
    }
    next.chi2 = move.allFinite() ? chi2_of(next) : INFINITY;
    if (next.chi2 <= state.chi2) {
      const bool settled = state.chi2 - next.chi2 < kSettled && damping < 1;
      state = std::move(next);
      if (settled) return true;
      damping = std::max(1e-9, 0.1 * damping);
      terms = linearise(state);
      at = gather(state, terms);
    } else {
      damping *= 8;
      if (damping > 1e8) return true;
    }
  }
  return at.ok;
}

}  // namespace reseau::psf
