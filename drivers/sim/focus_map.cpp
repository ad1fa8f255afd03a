#include "drivers/sim/focus_map.h"

#include <utility>

namespace reseau::sim {

FocusMap::FocusMap(std::shared_ptr<const Film> film, const OpticsSpec& optics,
                   const ScanGeometry& geometry)
    : film_(std::move(film)), optics_(optics), geometry_(geometry) {}

double FocusMap::common_um(double x, double y) const {
  const double rho = geometry_.rho(x);
  return optics_.focus_um + optics_.focus_tilt_um * rho + optics_.focus_curvature_um * rho * rho +
         optics_.focus_drift_um * y / 1000 + film_->height_um(x, y);
}

double FocusMap::defocus_um(int channel, double x, double y) const {
  return common_um(x, y) + chromatic_um(channel);
}

}  // namespace reseau::sim
