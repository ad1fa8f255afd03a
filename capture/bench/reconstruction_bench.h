// Reconstructions of simulated films against the truth about them.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "capture/bench/picture_score.h"
#include "core/reconstruct/reconstruct.h"

namespace reseau {

// A Gaussian blur that grows across the frame, and the noise of the scan that shows it.
struct BlurDrift {
  double first_px = 0, last_px = 0;
  double noise = 0;  // of full scale; the film's own settings add none
};

struct ReconstructionCase {
  std::string name;
  std::string film;  // settings of the simulated scanner, "key=value&key=value"
  std::optional<BlurDrift> drift = std::nullopt;
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
