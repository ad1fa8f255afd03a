// What a picture costs: time, memory and bandwidth, by size, quality and number of threads.
#pragma once

#include <cstddef>
#include <string>

#include "core/line/memory_line_source.h"
#include "core/reconstruct/demosaic.h"
#include "core/reconstruct/tone_curve.h"

namespace reseau {

struct SpeedCase {
  double megapixels = 1;
  bool half_black = false;  // no light falls on the left half
  Quality quality = Quality::kStandard;
  int n_threads = 0;
  bool exact = false;
  ToneCurves tone = ToneCurves::linear();
};

struct SpeedRun {
  bool found = false;
  std::string reason;  // when not found
  // Of the fastest of the runs: what else the machine does only slows them.
  double register_wall_s = 0, reconstruct_wall_s = 0;
  double register_cpu_s = 0, reconstruct_cpu_s = 0;  // medians
  std::size_t extra_bytes = 0;  // most memory beyond the scan; the picture is not kept
  // Read from the scan, twice, and written to the picture: what no program can do without.
  double least_bytes = 0;

  [[nodiscard]] double wall_s() const { return register_wall_s + reconstruct_wall_s; }
};

// A film of 2 : 3 in memory, red green blue infrared: one simulated megapixel laid side by side in
// step. Its red lines run at atan(5/12), 13 of its periods are 100 pixels, so that the réseau goes
// on across the seams.
[[nodiscard]] MemoryLineSource tiled_film(double megapixels, bool half_black);

// Registers and renders `repeat` times. Source: tiled_film of the case, or any scan.
[[nodiscard]] SpeedRun run_speed_case(const MemoryLineSource& source, const SpeedCase& test,
                                      int repeat);

}  // namespace reseau
