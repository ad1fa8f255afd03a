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

// Errors of the motion, in optical px on the film. All act on the nominal line positions.
struct StageSpec {
  double wobble_px = 0;       // largest error of a lead screw with two periods
  double wave_px = 0;         // amplitude of a sine along the motion
  double wave_lines = 225;    // lines per cycle of it
  double wave_phase_deg = 0;  // at line 0
  double sideways = 0;        // share of the sine that also displaces along the sensor
  double jitter_px = 0;       // standard deviation of a line's own error
  double walk_px = 0;         // standard deviation of the step of a random walk from line to line
};

struct SensorSpec {
  // Standard deviation at full scale, as a fraction of full scale: photon noise and a fifth of it
  // read noise.
  double noise = 0.002;
  int adc_bits = 16;
  double clear_level = 0.90;  // fraction of full scale that bare light reaches
};

}  // namespace reseau::sim
