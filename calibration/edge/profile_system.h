// What the files of ProfileFit share.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "calibration/edge/dense.h"
#include "calibration/edge/optics.h"
#include "calibration/edge/profile_fit.h"

namespace reseau {
namespace profile {

inline constexpr double kShadingSd = 0.4;  // of the contrast per reach

inline double sum_of_squares(double a) { return a * a; }

// Where a parameter means something; what leaves it is brought back.
inline double within(int parameter, double value, double width) {
  switch (parameter) {
    case kDiffraction:
      return std::clamp(value, -0.3 * width, 12 * width + 2);
    case kSigma2:
      return std::clamp(value, -0.5 * width * width, 6 * width * width);
    case kAperture2:
      return std::clamp(value, -3 * width * width, 24 * width * width);
    case kSmear2:
      return std::clamp(value, -3 * width * width, 24 * width * width);
    case kW20:
      return std::clamp(value, -2.5, 2.5);
    case kHalo:
      return std::clamp(value, -0.6, 0.6);
    default:
      return std::clamp(value, 1.5 * width, 40 * width);
  }
}

}  // namespace profile

struct ProfileFit::System {
  std::vector<int> parameters;
  EdgeOptics optics;
  // Levels, optics, shading, spline.
  Symmetric normal;
  std::vector<double> g;
  double squares = 0;  // weighted, of the residuals, between the bins
  std::size_t n_fixed = 0;
};

}  // namespace reseau
