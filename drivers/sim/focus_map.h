// How far the film lies from the focus of a channel.
#pragma once

#include <memory>

#include "drivers/sim/film.h"
#include "drivers/sim/optics_spec.h"
#include "drivers/sim/scan_geometry.h"

namespace reseau::sim {

// Immutable, thread-safe.
class FocusMap {
 public:
  FocusMap(std::shared_ptr<const Film> film, const OpticsSpec& optics,
           const ScanGeometry& geometry);

  // Distance from best focus at a place of the scan [um], positive towards the lens.
  [[nodiscard]] double defocus_um(int channel, double x, double y) const;
  // What all channels share of it.
  [[nodiscard]] double common_um(double x, double y) const;
  [[nodiscard]] double chromatic_um(int channel) const {
    return optics_.chromatic_focus_um[static_cast<std::size_t>(channel)];
  }

 private:
  std::shared_ptr<const Film> film_;
  OpticsSpec optics_;
  ScanGeometry geometry_;
};

}  // namespace reseau::sim
