// How far the spread may be from a Gaussian: a smooth difference, whose size the samples choose.
// Part of measure_random.
#pragma once

#include <Eigen/Core>

namespace reseau::random_target {

// Least squares of knots = contrast * gaussian + rest, with `n_others` more unknowns after the
// knots, about the present values. Rest has a covariance of `size` times the noise's variance times
// a smooth kernel; everything else is free.
struct SpreadSystem {
  Eigen::MatrixXd matrix;     // of knots and others
  Eigen::VectorXd right;      // for what is left over at present
  double squares = 0, n = 0;  // of what is left over
  Eigen::VectorXd gaussian;   // knots, sum 1
  Eigen::VectorXd rest;       // at present
};

struct SpreadStep {
  Eigen::VectorXd rest;        // whole
  double contrast = 0;         // step
  Eigen::VectorXd others;      // steps
  double variance = 0;         // of the noise of a sample
  Eigen::MatrixXd covariance;  // of the knots, everything else fitted along
};

class SpreadPrior {
 public:
  // Chooses length and size by restricted likelihood. sigma2: of the Gaussian, along both axes.
  SpreadPrior(const SpreadSystem& system, int n_knots, double step_px, double sigma2_u,
              double sigma2_v);
  [[nodiscard]] SpreadStep solve(const SpreadSystem& system, bool with_covariance) const;
  // Length of the kernel over the Gaussian's; size, of the noise's variance.
  [[nodiscard]] double length() const { return length_; }

 private:
  Eigen::MatrixXd precision_;  // of the rest, times the noise's variance
  double length_ = 0;
};

// Smallest over largest curvature by patterns below 0.75 cycles/px: none where the cells of the
// target repeat the pixels.
[[nodiscard]] double weakest_in_band(const Eigen::MatrixXd& by_knots, int n_knots, double step_px);

}  // namespace reseau::random_target
