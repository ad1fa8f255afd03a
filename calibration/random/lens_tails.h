// Light that a lens throws beyond the part of the spread that was fitted. Part of measure_random.
#pragma once

#include <Eigen/Core>

namespace reseau::random_target {

// Transfer along the axes of the scan at a few frequencies, of the part that was fitted.
struct AxisTransfer {
  Eigen::VectorXd f_cy_per_px;
  Eigen::VectorXd along_x;  // 1: along the sensor, 0: along the motion
  Eigen::VectorXd value;    // signed
  Eigen::MatrixXd covariance;
};

struct LensTails {
  bool ok = false;
  double diffraction_px = 0, diffraction_sd = 0;  // 1 / cut-off frequency
  double outside = 0, outside_sd = 0;             // share of the light beyond the support
};

// Diffraction, aperture and Gaussian through the values; beyond the core the light of a circular
// lens falls with the cube of the distance, by its cut-off alone. half_px: half the support's side.
[[nodiscard]] LensTails fit_tails(const AxisTransfer& transfer, double half_px);

}  // namespace reseau::random_target
