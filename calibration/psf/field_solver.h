// Least squares of fit_psf_field: every parameter is a polynomial over the frame. Include from .cpp
// files only (Eigen).
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "calibration/psf/psf_problem.h"
#include "core/geometry/vec2.h"

namespace reseau::psf {

inline constexpr int kMostOrder = 2;
[[nodiscard]] inline Eigen::Index terms_of(int order) {
  return order == 0 ? 1 : order == 1 ? 3 : 6;
}

struct FieldSurface {
  Block block = kBlockSigma;
  int channel = -1;  // -1: of the unit
  std::string name;
  int order = 0;
  Eigen::Matrix<double, 6, 1> c = Eigen::Matrix<double, 6, 1>::Zero();  // beyond the order: zero
};

struct FieldState {
  std::vector<FieldSurface> surfaces;
  std::vector<Eigen::Vector3d> own;  // offset, dark, bright of each edge
  double chi2 = 0;
  [[nodiscard]] Eigen::Index size() const;
};

// Curvature and slope of half the chi-squared by the coefficients of all surfaces, six each
// whatever their order; the edges' own unknowns are eliminated.
struct FieldNormal {
  Eigen::MatrixXd a;
  Eigen::VectorXd g;
  // How far the edges are from what they would choose by themselves, as chi-squared, and of how
  // many parameters.
  double apart = 0, n_apart = 0;
  bool ok = false;
};

class FieldSolver {
 public:
  // Places run from -1 to 1. `fixed`: of the parameters that are no surface. Refers to all of them.
  FieldSolver(std::span<const PsfEdge> edges, std::span<const Vec2> places, bool has_focus,
              const std::array<double, kSharedBlocks>& fixed);
  ~FieldSolver();
  FieldSolver(const FieldSolver&) = delete;
  FieldSolver& operator=(const FieldSolver&) = delete;

  // Levenberg and Marquardt from where `state` is. False when the profiles cannot be computed
  // there, or when it was stopped.
  [[nodiscard]] bool solve(FieldState& state, const std::function<bool()>& stop) const;
  [[nodiscard]] FieldNormal normal(const FieldState& state) const;
  // Which of the six coefficients of each surface are free.
  [[nodiscard]] static std::vector<Eigen::Index> free_of(const FieldState& state);

 private:
  struct Terms;
  [[nodiscard]] std::array<double, kSharedBlocks> local(const FieldState& state,
                                                        std::size_t edge) const;
  [[nodiscard]] double chi2_of(const FieldState& state) const;
  [[nodiscard]] std::vector<Terms> linearise(const FieldState& state) const;
  [[nodiscard]] FieldNormal gather(const FieldState& state, const std::vector<Terms>& terms) const;
  [[nodiscard]] bool applies(const FieldSurface& surface, std::size_t edge) const;

  std::span<const PsfEdge> edges_;
  std::vector<Eigen::Matrix<double, 6, 1>> basis_;  // of each edge
  std::vector<std::unique_ptr<ceres::CostFunction>> costs_;
  std::array<double, kSharedBlocks> fixed_;
};

}  // namespace reseau::psf
