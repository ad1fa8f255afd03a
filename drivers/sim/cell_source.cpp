#include "drivers/sim/cell_source.h"

#include <utility>

#include "core/base/check.h"
#include "drivers/sim/widest.h"

namespace reseau::sim {
namespace {

// 1 5 10 10 5 1.
void add_six(const float* p0, const float* p1, const float* p2, const float* p3, const float* p4,
             const float* p5, std::size_t n, float* __restrict to) {
  constexpr float kOuter = 1.0F / 32, kNext = 5.0F / 32, kInner = 10.0F / 32;
  widest([&]() RESEAU_SIM_INLINE {
    float* __restrict const out = to;
    for (std::size_t i = 0; i < n; ++i) {
      out[i] = kOuter * (p0[i] + p5[i]) + kNext * (p1[i] + p4[i]) + kInner * (p2[i] + p3[i]);
    }
  });
}

}  // namespace

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
  const auto slot = static_cast<std::size_t>(k & 7);
  if (at.index[slot] != k) {
    at.index[slot] = k;
    if (level == 0) {
      const double y = (static_cast<double>(k) + 0.5) / at.per_px - 0.5;
      at.rows[slot].set_tents(grid_.tents);
      film_->cells(y, first_px_, n_px_, at.per_px, at.rows[slot]);
    } else {
      join(level, k, at.rows[slot]);
    }
  }
  return at.rows[slot];
}

void CellSource::join(std::size_t level, std::int64_t k, CellRow& to) {
  const CellRow* from[6];
  for (int i = 0; i < 6; ++i) from[i] = &row(level - 1, 2 * k - 2 + i);
  const int per_px = levels_[level].per_px, fine_per_px = levels_[level - 1].per_px;
  to.resize(first_px_, n_px_, per_px);
  // Along y first, on all phases with one pixel to spare at both ends.
  const auto n = static_cast<std::size_t>(n_px_);
  const std::size_t stride = n + 2;
  joined_.resize(stride * static_cast<std::size_t>(fine_per_px));
  for (int c = 0; c < kChannels; ++c) {
    for (int s = 0; s < fine_per_px; ++s) {
      float* sum = joined_.data() + static_cast<std::size_t>(s) * stride;
      const float *p0 = from[0]->phase(c, s), *p1 = from[1]->phase(c, s),
                  *p2 = from[2]->phase(c, s), *p3 = from[3]->phase(c, s),
                  *p4 = from[4]->phase(c, s), *p5 = from[5]->phase(c, s);
      add_six(p0, p1, p2, p3, p4, p5, n, sum + 1);
      sum[0] = sum[1];
      sum[n + 1] = sum[n];
    }
    for (int s = 0; s < per_px; ++s) {
      // Fine cells 2 s - 2 to 2 s + 3; the outer ones may belong to a neighbouring pixel.
      const auto cell = [&](int at) {
        const int carry = at < 0 ? -1 : at >= fine_per_px ? 1 : 0;
        const auto phase = static_cast<std::size_t>(at - carry * fine_per_px);
        return joined_.data() + phase * stride + 1 + carry;
      };
      const float *p0 = cell(2 * s - 2), *p1 = cell(2 * s - 1), *p2 = cell(2 * s),
                  *p3 = cell(2 * s + 1), *p4 = cell(2 * s + 2), *p5 = cell(2 * s + 3);
      float* out = to.phase(c, s);
      add_six(p0, p1, p2, p3, p4, p5, n, out);
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
