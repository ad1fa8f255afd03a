// The map of the lines that are there so far, from a seed onwards.
#pragma once

#include <vector>

#include "core/screen/cell_moments.h"
#include "core/screen/lattice_search.h"
#include "core/screen/sample_grower.h"
#include "core/screen/screen_map.h"

namespace reseau {

// Follows the réseau block by block as lines arrive, and fits what is cheap: a plane, and a smooth
// displacement where that leaves something. The final map is made anew from all lines.
// Thread-bound.
class LiveMap {
 public:
  LiveMap(int width_px, int height_px, const LatticeSeed& seed);
  LiveMap(const LiveMap&) = delete;
  LiveMap& operator=(const LiveMap&) = delete;
  LiveMap(LiveMap&&) = delete;
  LiveMap& operator=(LiveMap&&) = delete;
  ~LiveMap() = default;

  // To be filled before advance().
  [[nodiscard]] CellGrid& cells() { return cells_; }
  // The cells of the lines [0, n_lines) are full: goes on to their end, or as far as whole blocks
  // are there. Never falls.
  void advance(int n_lines);

  // Lines [0, n_lines()) are what the map holds for; 0 while nothing holds.
  [[nodiscard]] int n_lines() const { return n_lines_; }
  [[nodiscard]] const ScreenMap& map() const { return map_; }
  [[nodiscard]] double residual_px() const { return residual_px_; }  // rms of the blocks about it
  [[nodiscard]] int n_samples() const { return n_samples_; }

 private:
  void fit(int n_lines);

  CellGrid cells_;
  BlockShape shape_;
  SampleGrower grower_;
  LatticeSeed seed_;
  int end_row_ = 0;  // of blocks
  ScreenMap map_;
  int n_lines_ = 0, n_samples_ = 0;
  double residual_px_ = 0;
};

// Blocks that hold four periods a side: less, and the picture speaks as loudly as the pattern.
[[nodiscard]] BlockShape block_of_four_periods(const CellGrid& cells, const Carriers& carriers);

}  // namespace reseau
