#include "core/color/white_balance.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"

namespace reseau {
namespace {
// An element this far below the brightest is dark: its share is noise.
constexpr double kDarkest = 1e-3;
}  // namespace

Vector3 neutral_white_balance(const Vector3& mean, const Matrix3& xyz_from_process) {
  const double brightest = *std::max_element(mean.begin(), mean.end());
  for (const double v : mean) {
    if (!std::isfinite(v) || !(v > 0) || v < kDarkest * brightest) {
      throw InputError(
          "There is no neutral to be found: one of the elements is dark all over; choose another "
          "area.");
    }
  }
  double luminance = 0, weights = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    luminance += xyz_from_process[3 + i] * mean[i];
    weights += xyz_from_process[3 + i];
  }
  const double grey = luminance / weights;
  return {grey / mean[0], grey / mean[1], grey / mean[2]};
}

}  // namespace reseau
