// What measure_random found, in the target's own axes, and how to read it. Part of measure_random.
#pragma once

#include <Eigen/Core>

#include "calibration/random/place_fit.h"
#include "calibration/random/random_target.h"
#include "core/geometry/vec2.h"

namespace reseau {

struct RandomPsf::Fit {
  random_target::BlurredPlace blurred;
  int n_knots = 0;  // along an axis
  double step_px = 0.5;
  Eigen::VectorXd knots;       // times contrast
  Eigen::MatrixXd covariance;  // of the knots, everything else fitted along
  Mat2 target_from_scan;
  Eigen::VectorXd shift_u, shift_v;  // of the middle, by knots over their sum
};

// psf, sd, relative_sd, side and step of `out` from its fit.
void fill_samples(RandomPsf& out);
// What lies beyond the support, of the lens; after fill_samples.
void find_tails(RandomPsf& out);

}  // namespace reseau
