// Reconstructions of simulated films against the truth about them.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "capture/bench/picture_score.h"
#include "core/line/memory_line_source.h"
#include "core/reconstruct/demosaic.h"
#include "core/reconstruct/reconstruct.h"
#include "drivers/sim/simulate.h"

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

// A film of a case, simulated and registered, to be reconstructed in several ways. Immutable.
class ReconstructionFilm {
 public:
  // Throws InputError for settings that make no film.
  ReconstructionFilm(const ReconstructionCase& test, int n_threads);

  // Everything automatic but the level of clear film and what is asked for here.
  [[nodiscard]] ReconstructionRun run(
      Quality quality, std::optional<Demosaic> demosaic, bool exact,
      std::optional<Deconvolution> deconvolution = std::nullopt) const;

 private:
  int n_threads_;
  double register_cpu_s_ = 0;
  sim::SimSpec spec_;
  sim::SimulatedScan scan_;
  std::optional<MemoryLineSource> source_;
  Registration registration_;
};

// One film, one way. Throws InputError for settings that make no film.
[[nodiscard]] ReconstructionRun run_reconstruction_case(const ReconstructionCase& test,
                                                        Quality quality, bool exact, int n_threads);

}  // namespace reseau
