#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace reseau::sim {

// Which cells of a row; of any pixels.
struct CellRange {
  int first_px = 0, n_px = 0, per_px = 1;
  bool tents = false;  // CellRow
  bool operator==(const CellRange&) const = default;
  [[nodiscard]] std::size_t size() const {
    return static_cast<std::size_t>(per_px) * static_cast<std::size_t>(n_px);
  }
};

// Of a cell's weight along either axis [cells^2].
[[nodiscard]] inline float variance_of(const CellRange& cells) {
  return cells.tents ? 1.0F / 6 : 1.0F / 12;
}

// A row of square cells with any number of values each, laid out as CellRow: [plane][phase][pixel].
class PlaneRow {
 public:
  void resize(int first_px, int n_px, int per_px, int n_planes) {
    first_px_ = first_px;
    n_px_ = n_px;
    per_px_ = per_px;
    values_.resize(static_cast<std::size_t>(n_planes) * plane_size());
  }
  [[nodiscard]] int first_px() const { return first_px_; }
  [[nodiscard]] int n_px() const { return n_px_; }
  [[nodiscard]] int per_px() const { return per_px_; }
  [[nodiscard]] std::size_t plane_size() const {
    return static_cast<std::size_t>(per_px_) * static_cast<std::size_t>(n_px_);
  }
  [[nodiscard]] float* plane(int p) {
    return values_.data() + static_cast<std::size_t>(p) * plane_size();
  }
  [[nodiscard]] const float* plane(int p) const {
    return values_.data() + static_cast<std::size_t>(p) * plane_size();
  }
  [[nodiscard]] float* phase(int p, int s) { return plane(p) + s * n_px_; }
  [[nodiscard]] const float* phase(int p, int s) const { return plane(p) + s * n_px_; }

 private:
  int first_px_ = 0, n_px_ = 0, per_px_ = 1;
  std::vector<float> values_;
};

// Place of cell s of a pixel relative to the pixel's centre.
[[nodiscard]] inline double cell_offset_px(int s, int per_px) { return (s + 0.5) / per_px - 0.5; }

}  // namespace reseau::sim
