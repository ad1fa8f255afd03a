#include "drivers/sim/cell_source.h"

#include <utility>

#include "core/base/check.h"

namespace reseau::sim {

CellSource::CellSource(std::shared_ptr<const Film> film, const CellGrid& grid, int first_px,
                       int n_px)
    : film_(std::move(film)), grid_(grid), first_px_(first_px), n_px_(n_px) {
  for (int cells = grid.fine_per_px; cells >= grid.per_px; cells /= 2) {
    levels_.emplace_back().per_px = cells;
    CHECK(cells == grid.per_px || cells % 2 == 0);
  }
  CHECK(!levels_.empty() && levels_.back().per_px == grid.per_px);
}

const CellRow& CellSource::row(std::size_t level, std::int64_t k) {
  Level& at = levels_[level];
  const auto slot = static_cast<std::size_t>(k & 3);
  if (at.index[slot] != k) {
    at.index[slot] = k;
    if (level == 0) {
      const double y = (static_cast<double>(k) + 0.5) / at.per_px - 0.5;
      film_->cells(y, first_px_, n_px_, at.per_px, at.rows[slot]);
    } else {
      join(level, k, at.rows[slot]);
    }
  }
  return at.rows[slot];
}

void CellSource::join(std::size_t level, std::int64_t k, CellRow& to) {
  const CellRow *a = &row(level - 1, 2 * k - 1), *b = &row(level - 1, 2 * k),
                *d = &row(level - 1, 2 * k + 1), *e = &row(level - 1, 2 * k + 2);
  const int per_px = levels_[level].per_px, fine_per_px = levels_[level - 1].per_px;
  to.resize(first_px_, n_px_, per_px);
  // Along y first, on all phases with one pixel to spare at both ends.
  const auto n = static_cast<std::size_t>(n_px_);
  const std::size_t stride = n + 2;
  joined_.resize(stride * static_cast<std::size_t>(fine_per_px));
  for (int c = 0; c < kChannels; ++c) {
    for (int s = 0; s < fine_per_px; ++s) {
      float* sum = joined_.data() + static_cast<std::size_t>(s) * stride;
      const float *p = a->phase(c, s), *q = b->phase(c, s), *r = d->phase(c, s),
                  *t = e->phase(c, s);
      for (std::size_t i = 0; i < n; ++i) {
        sum[i + 1] = 0.125F * (p[i] + t[i]) + 0.375F * (q[i] + r[i]);
      }
      sum[0] = sum[1];
      sum[n + 1] = sum[n];
    }
    for (int s = 0; s < per_px; ++s) {
      // Fine cells 2 s - 1 to 2 s + 2; the outer ones may belong to a neighbouring pixel.
      const auto cell = [&](int at) {
        const int carry = at < 0 ? -1 : at >= fine_per_px ? 1 : 0;
        const auto phase = static_cast<std::size_t>(at - carry * fine_per_px);
        return joined_.data() + phase * stride + 1 + carry;
      };
      const float *p = cell(2 * s - 1), *q = cell(2 * s), *r = cell(2 * s + 1),
                  *t = cell(2 * s + 2);
      float* out = to.phase(c, s);
      for (std::size_t i = 0; i < n; ++i) {
        out[i] = 0.125F * (p[i] + t[i]) + 0.375F * (q[i] + r[i]);
      }
    }
  }
}

void CellSource::read(std::int64_t j, const std::array<std::span<float>, kChannels>& out) {
  const CellRow& from = row(levels_.size() - 1, j);
  const auto n = static_cast<std::size_t>(n_px_), per_px = static_cast<std::size_t>(grid_.per_px);
  for (int c = 0; c < kChannels; ++c) {
    float* to = out[static_cast<std::size_t>(c)].data();
    for (std::size_t s = 0; s < per_px; ++s) {
      const float* phase = from.phase(c, static_cast<int>(s));
      for (std::size_t i = 0; i < n; ++i) to[i * per_px + s] = phase[i];
    }
  }
}

}  // namespace reseau::sim
