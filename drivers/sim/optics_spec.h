// Parameters of the simulated optics and sensor. Plain values; sim_spec.h parses and checks them.
#pragma once

#include <array>

namespace reseau::sim {

struct OpticsSpec {
  // Standard deviation of the Gaussian per channel [optical px]; the pixel aperture comes on top.
  std::array<double, 4> blur_px{0.6, 0.6, 0.6, 0.7};
  double aperture_px = 1.0;  // width of the square over which a pixel integrates
  int cells_per_px = 4;      // of the numerical integration
};

struct SensorSpec {
  // Standard deviation at full scale, as a fraction of full scale: photon noise and a fifth of it
  // read noise.
  double noise = 0.002;
  int adc_bits = 16;
  double clear_level = 0.90;  // fraction of full scale that bare light reaches
};

}  // namespace reseau::sim
