// One simulated film registered and compared with the truth about it.
#pragma once

#include <string>

#include "capture/bench/registration_cases.h"
#include "core/reconstruct/reconstruct.h"
#include "drivers/sim/simulate.h"

namespace reseau {

struct RegistrationScore {
  bool found = false;
  std::string reason;
  std::string screen, true_screen;
  double rms_px = 0;      // error of the map over the frame
  double lit_rms_px = 0;  // the same where there is light
  double max_px = 0;
  double z_sd = 0;      // rms of error over claimed standard deviation, where there is light
  double sd_px = 0;     // rms of the claimed standard deviation there
  double worst_z = 0;   // the largest error over the standard deviation claimed there
  double bound_px = 0;  // Cramér-Rao bound of the film's map, rms over the frame
  double residual_px = 0;
  bool affine = false;
  double cpu_s = 0, wall_s = 0;
};

// What was found in a simulated scan, without times.
[[nodiscard]] RegistrationScore compare_with_truth(const sim::SimulatedScan& scan,
                                                   const Registration& found);
// Simulates, registers, compares. Throws InputError for settings that make no film.
[[nodiscard]] RegistrationScore score_registration(const RegistrationCase& test, int n_threads);
// Of several noises and scenes, seeds 1 to n_seeds: rms over them of errors and of z, the largest
// of what is largest, means of times; found only where all were.
[[nodiscard]] RegistrationScore score_registration(const RegistrationCase& test, int n_threads,
                                                   int n_seeds);

}  // namespace reseau
