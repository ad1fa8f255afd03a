// Reconstructions of simulated films against the truth about them.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "capture/bench/picture_score.h"
#include "core/reconstruct/reconstruct.h"

namespace reseau {

struct ReconstructionCase {
  std::string name;
  std::string film;  // settings of the simulated scanner, "key=value&key=value"
};

// One megapixel each: blurs, noise, drifting focus, deformed and turned film.
[[nodiscard]] std::vector<ReconstructionCase> reconstruction_cases();

struct ReconstructionRun {
  bool found = false;
  std::string reason;  // when not found
  PictureScore score;
  double register_cpu_s = 0, reconstruct_cpu_s = 0, reconstruct_wall_s = 0;
  ReconstructionReport report;
};

// Simulates, registers, reconstructs, compares; everything automatic but the level of clear film.
// Throws InputError for settings that make no film.
[[nodiscard]] ReconstructionRun run_reconstruction_case(const ReconstructionCase& test,
                                                        Quality quality, bool exact, int n_threads);

}  // namespace reseau
