#include "drivers/sim/film/light_rows.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "drivers/sim/film.h"
#include "drivers/sim/widest.h"

namespace reseau::sim {
namespace {

// The values in the cell above, below, to the left, to the right.
struct Around {
  const float *above, *below, *left, *right;
};

// Means of the product of two quantities: of their means, and to the next order the variance of a
// cell's weight x the product of their changes per cell, along both axes.
void multiply(const float* a, const float* b, const Around& of_a, const Around& of_b, std::size_t n,
              float variance, float* to) {
  const float gain = variance / 4;
  widest([&]() RESEAU_SIM_INLINE {
    float* __restrict const out = to;
    const float by = gain;
    const float *const at_a = a, *const at_b = b;
    const float *const a0 = of_a.above, *const a1 = of_a.below, *const a2 = of_a.left,
                       *const a3 = of_a.right;
    const float *const b0 = of_b.above, *const b1 = of_b.below, *const b2 = of_b.left,
                       *const b3 = of_b.right;
    for (std::size_t i = 0; i < n; ++i) {
      const float along_y = (a1[i] - a0[i]) * (b1[i] - b0[i]);
      const float along_x = (a3[i] - a2[i]) * (b3[i] - b2[i]);
      out[i] = at_a[i] * at_b[i] + (along_y + along_x) * by;
    }
  });
}

void by_phases(const float* from, std::size_t n_px, std::size_t per_px, std::vector<float>& out) {
  out.resize(n_px * per_px);
  for (std::size_t s = 0; s < per_px; ++s) {
    for (std::size_t i = 0; i < n_px; ++i) out[s * n_px + i] = from[i * per_px + s];
  }
}

// Means over cells from the values at the middles of three rows of them, cell after cell; laid out
// by phases. The first and the last cell keep their value.
void means_of(const float* above, const float* here, const float* below, std::size_t n_px,
              std::size_t per_px, float variance, std::vector<float>& out) {
  const float bend = variance / 2;
  const std::size_t n = n_px * per_px;
  thread_local std::vector<float> in_order;
  in_order.resize(n);
  widest([&]() RESEAU_SIM_INLINE {
    float* __restrict const to = in_order.data();
    for (std::size_t i = 1; i + 1 < n; ++i) {
      const float around = (above[i] + below[i]) + (here[i - 1] + here[i + 1]);
      to[i] = here[i] + (around - 4 * here[i]) * bend;
    }
  });
  in_order.front() = here[0];
  in_order.back() = here[n - 1];
  by_phases(in_order.data(), n_px, per_px, out);
}

}  // namespace

const LightRows::Made& LightRows::made(std::int64_t row) {
  Made& made = made_[static_cast<std::size_t>(row & 7)];
  if (made.row == row) return made;
  made.row = row;
  const double y = height_of(row);
  if (film_->silver.spreads()) {
    film_->silver.field(y, cells_, made.silver);
  } else {
    film_->silver.behind_sets(y, cells_, made.silver);
  }
  if (film_->painter != nullptr) film_->silver.areas(y, cells_, made.areas);
  return made;
}

// Specks are hardly wider than a few cells and their middles and edges are sharp: cells take the
// mean of four places with the variance of a cell.
bool LightRows::harm(double y, double x, double step, Texture& t) {
  const auto n = static_cast<std::size_t>(cells_.n_px) * static_cast<std::size_t>(cells_.per_px);
  const double off = std::sqrt(static_cast<double>(variance_of(cells_)));
  point_[0].resize(n);
  point_[1].resize(n);
  float whole_before = 0;
  bool harmed = false;
  for (int k = 0; k < (coarse_ ? 4 : 1); ++k) {
    const float share = coarse_ ? 0.25F : 1.0F;
    const double down = !coarse_ ? 0.0 : k < 2 ? -off : off;
    const double across = !coarse_ ? 0.0 : k % 2 == 0 ? -off : off;
    const bool here = film_->damage->local(y + down / cells_.per_px, x + across * step, step,
                                           {point_[0], point_[1]});
    if (here && !harmed) {
      t.whole.assign(n, whole_before);
      t.bared.assign(n, 0.0F);
      harmed = true;
    }
    whole_before += share;
    if (!harmed) continue;
    const float *const lets = point_[0].data(), *const bared = point_[1].data();
    float *const whole = t.whole.data(), *const gone = t.bared.data();
    widest([&]() RESEAU_SIM_INLINE {
      float* __restrict const to_whole = whole, * __restrict const to_bared = gone;
      for (std::size_t i = 0; i < n; ++i) {
        to_whole[i] += share * (here ? lets[i] * (1 - bared[i]) : 1.0F);
        to_bared[i] += share * (here ? lets[i] * bared[i] : 0.0F);
      }
    });
  }
  return harmed;
}

const LightRows::Texture& LightRows::texture(std::int64_t row) {
  Texture& t = textures_[static_cast<std::size_t>(row & 3)];
  if (t.row == row) return t;
  t.row = row;
  const auto n = static_cast<std::size_t>(cells_.n_px) * static_cast<std::size_t>(cells_.per_px);
  const double y = height_of(row), step = (film_->mirrored ? -1.0 : 1.0) / cells_.per_px;
  const double first = cells_.first_px + cell_offset_px(0, cells_.per_px);
  const double x = film_->strip.film_from_scan(first, y).x;
  t.harmed = harm_ && film_->damage != nullptr && film_->damage->has_local() && harm(y, x, step, t);
  if (has_grain()) {
    t.grain.resize(n);
    film_->grain->texture(y, x, step, t.grain);
    if (t.harmed) {
      for (std::size_t i = 0; i < n; ++i) t.grain[i] *= t.whole[i];
    }
  }
  return t;
}

// Silver T whose grain makes it T + g(T) m, of which harm leaves w (1 where there is none) and a
// scratch bares b: T w + g(T) (m w) + b. T changes slowly against these; their means are taken.
void LightRows::apply_texture(std::int64_t row, PlaneRow& silver) {
  const Texture& here = texture(row);
  const bool harmed = here.harmed;
  const bool grainy = has_grain();
  const Texture* const above = grainy && coarse_ ? &texture(row - 1) : &here;
  const Texture* const below = grainy && coarse_ ? &texture(row + 1) : &here;
  const auto n_px = static_cast<std::size_t>(cells_.n_px);
  const auto per_px = static_cast<std::size_t>(cells_.per_px);
  const auto n = n_px * per_px;
  if (grainy && coarse_) {
    means_of(above->grain.data(), here.grain.data(), below->grain.data(), n_px, per_px,
             variance_of(cells_), means_[0]);
  } else if (grainy) {
    by_phases(here.grain.data(), n_px, per_px, means_[0]);
  }
  if (harmed) {
    by_phases(here.whole.data(), n_px, per_px, means_[1]);
    by_phases(here.bared.data(), n_px, per_px, means_[2]);
  }
  if (!grainy && !harmed) return;
  const int n_planes = film_->silver.spreads() || film_->painter == nullptr
                           ? 1
                           : static_cast<int>(film_->painter->sets().size());
  depth_.resize(n);
  for (int k = 0; k < n_planes; ++k) {
    float* const t = silver.plane(k);
    if (grainy) film_->grain->depths({t, n}, depth_);
    if (harmed) {
      const float *const whole = means_[1].data(), *const bared = means_[2].data();
      for (std::size_t i = 0; i < n; ++i) t[i] = t[i] * whole[i] + bared[i];
    }
    if (grainy) {
      const float *const m = means_[0].data(), *const depth = depth_.data();
      widest([&]() RESEAU_SIM_INLINE {
        float* __restrict const silvered = t;
        for (std::size_t i = 0; i < n; ++i) silvered[i] += depth[i] * m[i];
      });
    }
  }
}

// Between pixels the silver is straight: even cells lie in one such part, tents reach over its end.
void LightRows::bend_across(const PlaneRow& silver, int n_planes, PlaneRow& to) const {
  const auto n = static_cast<std::size_t>(cells_.n_px);
  for (int k = 0; k < n_planes; ++k) {
    for (int s = 0; s < cells_.per_px; ++s) {
      const bool first = s == 0, last = s + 1 == cells_.per_px;
      const float* const here = silver.phase(k, s);
      const float* const left = silver.phase(k, first ? cells_.per_px - 1 : s - 1);
      const float* const right = silver.phase(k, last ? 0 : s + 1);
      float* const out = to.phase(k, s);
      for (std::size_t i = 1; i + 1 < n; ++i) {
        const float around = left[first ? i - 1 : i] + right[last ? i + 1 : i];
        out[i] += (around - 2 * here[i]) * (1.0F / 24);
      }
    }
  }
}

const LightRows::Finished& LightRows::finished(std::int64_t row) {
  Finished& to = finished_[static_cast<std::size_t>(row & 3)];
  if (to.row == row) return to;
  to.row = row;
  const auto& [first_px, n_px, per_px, tents] = cells_;
  // A scene without fine detail is known at the middles of rows of cells; a field is a mean.
  const bool bends = coarse_ && !film_->silver.spreads() && !film_->strip.has_fine_detail();
  const Made* const above = bends ? &made(row - 1) : nullptr;
  const Made& here = made(row);
  const Made* const below = bends ? &made(row + 1) : nullptr;
  const int n_planes = film_->silver.spreads() || film_->painter == nullptr
                           ? 1
                           : static_cast<int>(film_->painter->sets().size());
  to.silver.resize(first_px, n_px, per_px, n_planes);
  const std::size_t n = static_cast<std::size_t>(n_planes) * to.silver.plane_size();
  const float* const t = here.silver.plane(0);
  float* const out = to.silver.plane(0);
  if (bends) {
    const float *const t0 = above->silver.plane(0), *const t1 = below->silver.plane(0);
    const float bend = variance_of(cells_) / 2;
    widest([&]() RESEAU_SIM_INLINE {
      float* __restrict const mean = out;
      for (std::size_t i = 0; i < n; ++i) mean[i] = t[i] + (t0[i] - 2 * t[i] + t1[i]) * bend;
    });
    if (tents) bend_across(here.silver, n_planes, to.silver);
  } else {
    std::copy_n(t, n, out);
  }
  apply_texture(row, to.silver);
  return to;
}

const PlaneRow& LightRows::row(const FilmLayers& film, double y, const CellRange& cells,
                               bool harm) {
  // Two pixels on either side for neighbours and their means.
  const int begin = cells.first_px - 2, end = cells.first_px + cells.n_px + 2;
  const CellRange wider{begin, end - begin, cells.per_px, cells.tents};
  const int offset = cells.first_px - begin;
  // Far cells look at their neighbours for the sake of the order of the method, single ones do not.
  const double side = 1.0 / cells.per_px;
  const bool coarse =
      cells.per_px > 1 && film.strip.on_film(y - 2 * side) && film.strip.on_film(y + 2 * side);
  film_ = &film;
  if (id_ != film.id || cells_ != wider || harm_ != harm || coarse_ != coarse) {
    id_ = film.id;
    cells_ = wider;
    harm_ = harm;
    coarse_ = coarse;
    for (Made& each : made_) each.row = INT64_MIN;
    for (Texture& each : textures_) each.row = INT64_MIN;
    for (Finished& each : finished_) each.row = INT64_MIN;
  }
  const std::int64_t row = std::llround((y + 0.5) * cells.per_px - 0.5);
  // In ascending order, as the rings of the emulsion like it.
  const Finished* const above = coarse ? &finished(row - 1) : nullptr;
  const Finished& here = finished(row);
  const Finished* const below = coarse ? &finished(row + 1) : nullptr;
  const int n_sets = film.painter == nullptr ? 1 : static_cast<int>(film.painter->sets().size());
  const auto n = static_cast<std::size_t>(cells.n_px);
  const int per_px = cells.per_px;
  light_.resize(cells.first_px, cells.n_px, per_px, n_sets);
  for (int k = 0; k < n_sets; ++k) {
    const int plane = plane_of(k);
    const auto silver = [&](const Finished& of, int s) {
      return of.silver.phase(plane, s) + offset;
    };
    for (int s = 0; s < per_px; ++s) {
      float* const to = light_.phase(k, s);
      const float* const t = silver(here, s);
      if (film.painter == nullptr) {
        std::copy_n(t, n, to);
        continue;
      }
      const auto area = [&](std::int64_t of, int phase) {
        return made(of).areas.phase(k, phase) + offset;
      };
      const float* const a = area(row, s);
      if (!coarse) {
        widest([&]() RESEAU_SIM_INLINE {
          float* __restrict const product = to;
          for (std::size_t i = 0; i < n; ++i) product[i] = a[i] * t[i];
        });
        continue;
      }
      // The cells left and right may belong to the neighbouring pixel.
      const int left = s == 0 ? per_px - 1 : s - 1, right = s + 1 == per_px ? 0 : s + 1;
      const int from_left = s == 0 ? 1 : 0, from_right = s + 1 == per_px ? 1 : 0;
      const Around areas{area(row - 1, s), area(row + 1, s), area(row, left) - from_left,
                         area(row, right) + from_right};
      const Around silvers{silver(*above, s), silver(*below, s), silver(here, left) - from_left,
                           silver(here, right) + from_right};
      multiply(a, t, areas, silvers, n, variance_of(cells), to);
    }
  }
  return light_;
}

}  // namespace reseau::sim
