// Simulated films that registration is measured on, with the error that each may have.
#pragma once

#include <string>
#include <vector>

namespace reseau {

struct RegistrationCase {
  std::string name;
  std::string film;       // settings of the simulated scanner, "key=value&key=value"
  double bar_px = 0;      // rms over the frame that is to be kept; 0 = no bar is set
  bool lit_only = false;  // judged where any light is
  std::string group;      // table that the case stands in
};

// The cases that say whether registration does what it should, 1 megapixel each unless named.
[[nodiscard]] std::vector<RegistrationCase> registration_bars();
// Sweeps of one setting at a time: blur, noise, angle, period, fading, deformation, jitter, size.
[[nodiscard]] std::vector<RegistrationCase> registration_sweeps();

}  // namespace reseau
