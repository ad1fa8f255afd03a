// Scans and parameters that break programs: an answer within its own stated uncertainty, or a
// sentence that there is none.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/reconstruct/reconstruct.h"
#include "drivers/sim/simulate.h"

namespace reseau {

// What a case may still do to the scan and to the options of the reconstruction.
struct StressInput {
  sim::SimulatedScan& scan;
  ReconstructOptions& options;
};

struct StressCase {
  std::string group, name;
  std::string film;  // settings of the simulated scanner, "key=value&key=value"
  std::function<void(StressInput)> harm = {};
  // Whether the truth about the map still holds after the harm.
  bool truth_holds = true;
};

enum class StressOutcome {
  kAnswered,  // every sample is finite, the map is off by no more than it may be
  kRefused,   // a sentence says why there is no picture
  kFailed,    // neither
};

struct StressResult {
  StressOutcome outcome = StressOutcome::kFailed;
  std::string words;          // of the refusal, or of what failed
  double off_px = 0;          // of the map, rms where there is light
  double claimed_px = 0;      // as the map says of itself there
  double condition = 0;       // of the mean 3 x 3 crosstalk
  double noise_gain = 0;      // of its regularised inverse
  double largest_sample = 0;  // of the picture, absolute
  bool same_bytes = true;     // with one thread and with five
};

// Blur to an MTF of 0.05 at the réseau and beyond, noise to a signal of three times it, angles,
// reversed contrast, mirrored, black, dust, no réseau, two of them, shapes, sizes, faded dyes,
// parameters that are no numbers; and `n_random` films by lot, the same for the same seed.
[[nodiscard]] std::vector<StressCase> stress_cases(int n_random, unsigned seed);

// Registers and renders at standard quality. Never throws for what the case does.
[[nodiscard]] StressResult run_stress_case(const StressCase& test);

}  // namespace reseau
