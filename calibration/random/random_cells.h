// The printed target: square cells that are clear or opaque by chance.
//
// Column c of row r, both from 0 to n - 1 from the upper left corner, is clear where the highest
// bit of h(h(seed K + c A + r B)) is set, in 64 bits without carry; h(z): z = (z ^ z >> 30)
// BF58476D1CE4E5B9h, z = (z ^ z >> 27) 94D049BB133111EBh, z = z ^ z >> 31. K, A, B:
// 9E3779B97F4A7C15h, D1B54A32D192ED03h, 8CB92BA72F3D8DD7h. Around the cells it is opaque.
#pragma once

#include <cstdint>
#include <vector>

namespace reseau {

struct RandomTarget {
  std::uint64_t seed = 1;
  double cell_px = 0.5;  // side of a cell as the scanner should see it, 0.2 to 1.5
  int n_cells = 1024;    // along either side
};

// Immutable. Places are told from the middle of the target [px].
class RandomCells {
 public:
  explicit RandomCells(const RandomTarget& target);
  [[nodiscard]] double cell_px() const { return target_.cell_px; }
  [[nodiscard]] int n_cells() const { return target_.n_cells; }
  // From the corner; outside of the target nothing is clear.
  [[nodiscard]] bool clear(std::int64_t column, std::int64_t row) const {
    const std::int64_t n = target_.n_cells;
    return column >= 0 && row >= 0 && column < n && row < n &&
           clear_[static_cast<std::size_t>(row * n + column)] != 0;
  }
  // The border before a column or row, from the middle.
  [[nodiscard]] double border_px(std::int64_t cell) const {
    return (static_cast<double>(cell) - 0.5 * target_.n_cells) * target_.cell_px;
  }
  // The column or row at this distance from the middle.
  [[nodiscard]] std::int64_t cell_at(double px) const;

 private:
  RandomTarget target_;
  std::vector<std::uint8_t> clear_;
};

}  // namespace reseau
