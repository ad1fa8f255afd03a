#include "drivers/sim/cell_source.h"

#include <utility>

#include "core/base/check.h"

namespace reseau::sim {

CellSource::CellSource(std::shared_ptr<const Film> film, const CellGrid& grid, int first_px,
                       int n_px)
    : film_(std::move(film)), grid_(grid), first_px_(first_px), n_px_(n_px) {
  CHECK(grid.per_px == grid.fine_per_px || 2 * grid.per_px == grid.fine_per_px);
}

const CellRow& CellSource::fine(std::int64_t k) {
  const auto slot = static_cast<std::size_t>(k & 3);
  if (row_index_[slot] != k) {
    row_index_[slot] = k;
    const double y = (static_cast<double>(k) + 0.5) / grid_.fine_per_px - 0.5;
    film_->cells(y, first_px_, n_px_, grid_.fine_per_px, rows_[slot]);
  }
  return rows_[slot];
}

void CellSource::read(std::int64_t j, const std::array<std::span<float>, kChannels>& out) {
  const auto n = static_cast<std::size_t>(n_px_), per_px = static_cast<std::size_t>(grid_.per_px);
  if (grid_.per_px == grid_.fine_per_px) {
    const CellRow& row = fine(j);
    for (int c = 0; c < kChannels; ++c) {
      float* to = out[static_cast<std::size_t>(c)].data();
      for (std::size_t s = 0; s < per_px; ++s) {
        const float* from = row.phase(c, static_cast<int>(s));
        for (std::size_t i = 0; i < n; ++i) to[i * per_px + s] = from[i];
      }
    }
    return;
  }
  const CellRow *a = &fine(2 * j - 1), *b = &fine(2 * j), *d = &fine(2 * j + 1),
                *e = &fine(2 * j + 2);
  // Along y first, on all phases with one pixel to spare at both ends.
  const std::size_t stride = n + 2;
  const int fine_per_px = grid_.fine_per_px;
  joined_.resize(stride * static_cast<std::size_t>(fine_per_px));
  for (int c = 0; c < kChannels; ++c) {
    for (int s = 0; s < fine_per_px; ++s) {
      float* to = joined_.data() + static_cast<std::size_t>(s) * stride;
      const float *p = a->phase(c, s), *q = b->phase(c, s), *r = d->phase(c, s),
                  *t = e->phase(c, s);
      for (std::size_t i = 0; i < n; ++i) {
        to[i + 1] = 0.125F * (p[i] + t[i]) + 0.375F * (q[i] + r[i]);
      }
      to[0] = to[1];
      to[n + 1] = to[n];
    }
    float* to = out[static_cast<std::size_t>(c)].data();
    for (int s = 0; s < grid_.per_px; ++s) {
      // Fine cells 2 s - 1 to 2 s + 2; the outer ones may belong to a neighbouring pixel.
      const auto cell = [&](int k) {
        const int carry = k < 0 ? -1 : k >= fine_per_px ? 1 : 0;
        const auto phase = static_cast<std::size_t>(k - carry * fine_per_px);
        return joined_.data() + phase * stride + 1 + carry;
      };
      const float *p = cell(2 * s - 1), *q = cell(2 * s), *r = cell(2 * s + 1),
                  *t = cell(2 * s + 2);
      for (std::size_t i = 0; i < n; ++i) {
        to[i * per_px + static_cast<std::size_t>(s)] =
            0.125F * (p[i] + t[i]) + 0.375F * (q[i] + r[i]);
      }
    }
  }
}

}  // namespace reseau::sim
