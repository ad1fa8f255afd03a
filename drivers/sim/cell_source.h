// Rows of cells of the film on the grid a spread function is applied on.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "drivers/sim/film.h"
#include "drivers/sim/psf_family.h"

namespace reseau::sim {

// Thread-bound; rows are asked for in any order, cheapest in ascending order.
class CellSource {
 public:
  // first_px and n_px: multiples of kBlockPx.
  CellSource(std::shared_ptr<const Film> film, const CellGrid& grid, int first_px, int n_px);

  // Row j lies at y = (j + 0.5) / per_px - 0.5; sample k of it at x = first_px + (k + 0.5) / per_px
  // - 0.5. out: n_px * per_px per channel.
  void read(std::int64_t j, const std::array<std::span<float>, kChannels>& out);

 private:
  // Rows of one size of cells, the latest eight; each level joins pairs of the one before.
  struct Level {
    int per_px = 0;
    std::array<CellRow, 8> rows;
    std::array<std::int64_t, 8> index{INT64_MIN, INT64_MIN, INT64_MIN, INT64_MIN,
                                      INT64_MIN, INT64_MIN, INT64_MIN, INT64_MIN};
  };
  const CellRow& row(std::size_t level, std::int64_t k);
  void join(std::size_t level, std::int64_t k, CellRow& to);

  std::shared_ptr<const Film> film_;
  CellGrid grid_;
  int first_px_, n_px_;
  std::vector<Level> levels_;
  std::vector<float> joined_;
};

}  // namespace reseau::sim
