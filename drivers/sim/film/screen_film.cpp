#include "drivers/sim/film/screen_film.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/check.h"
#include "drivers/sim/film/edge_directions.h"
#include "drivers/sim/hash.h"

namespace reseau::sim {
namespace {

DyeSpec faded_dyes(DyeSpec dyes) {
  dyes.fade += (1 - dyes.fade) * Damage::kWorstFade;
  return dyes;
}

// Smaller cells are exact enough by the product of their means.
constexpr int kCellsThatNeedIt = 12;

std::uint64_t next_film() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

// Adds 1/12 of the product of two changes per cell, from the values in the cells before and after.
void add_products(const float* a0, const float* a1, const float* t0, const float* t1, std::size_t n,
                  float* to) {
  for (std::size_t i = 0; i < n; ++i) to[i] += (a1[i] - a0[i]) * (t1[i] - t0[i]) * (1.0F / 48);
}

// Fraction of a cell centred at x that lies at smaller coordinates than `edge`.
float part_below(double edge, double x, double cell_px) {
  return static_cast<float>(std::clamp((edge - x) / cell_px + 0.5, 0.0, 1.0));
}

}  // namespace

// What a row of cells is made of.
struct ScreenFilm::Made {
  std::int64_t row = INT64_MIN;
  PlaneRow areas, silver;  // silver behind each set of dyes, or one field
};

// One row of cells in the making, and those around it. One per thread.
struct ScreenFilm::Rows {
  std::uint64_t film = 0;
  int first_px = 0, n_px = 0, per_px = 0;
  std::array<Made, 4> made;
  PlaneRow light;             // of each set of dyes: area x silver
  std::vector<float> silver;  // of each cell, all channels' [phase][pixel]
  std::vector<float> faded, factor, transmittance, bared, stain;
};

ScreenFilm::ScreenFilm(const FilmSpec& spec)
    : spec_(spec),
      strip_(spec),
      screen_(spec),
      painter_(spec.kind == FilmKind::kPlain ? nullptr : std::make_unique<ElementPainter>(spec)),
      silver_(spec, strip_, painter_.get()),
      response_(dye_set_response(spec.dyes)),
      faded_response_(dye_set_response(faded_dyes(spec.dyes))),
      grain_(spec.emulsion.grain, spec.emulsion.grain_um / spec.frame.pixel_um,
             mix64(spec.seed, 0x64a1)),
      damage_(spec),
      edges_(edges_of(spec)),
      id_(next_film()) {
  CHECK(spec.kind != FilmKind::kEmpty);
}

double ScreenFilm::height_um(double x, double /*y*/) const { return screen_.height_um(x); }

ScreenFilm::Rows& ScreenFilm::rows_of_thread() {
  thread_local Rows rows;
  return rows;
}

void ScreenFilm::cells(double y, int first_px, int n_px, int per_px, CellRow& out) const {
  silver_cells(y, first_px, n_px, per_px, out);
  if (!strip_.on_film(y)) return;
  apply_damage(y, rows_of_thread(), out);
  if (spec_.frame.outside_px > 0) apply_film_edge(out);
}

void ScreenFilm::silver_cells(double y, int first_px, int n_px, int per_px, CellRow& out) const {
  CHECK(first_px % kBlockPx == 0 && n_px % kBlockPx == 0 && per_px >= 1);
  out.resize(first_px, n_px, per_px);
  if (!strip_.on_film(y)) {
    for (int c = 0; c < kChannels; ++c) std::fill_n(out.phase(c, 0), n_px * per_px, 1.0F);
    return;
  }
  Rows& rows = rows_of_thread();
  join_rows(y, rows, out);
  mix(y, rows, out);
  if (!grain_.is_off()) apply_grain(y, rows, out);
}

const ScreenFilm::Made& ScreenFilm::made(Rows& rows, double y, int below,
                                         const CellRow& out) const {
  // A block more on both sides: every cell of the row has neighbours.
  const int first_px = out.first_px() - kBlockPx, n_px = out.n_px() + 2 * kBlockPx;
  const int per_px = out.per_px();
  if (rows.film != id_ || rows.first_px != first_px || rows.n_px != n_px || rows.per_px != per_px) {
    rows.film = id_;
    rows.first_px = first_px;
    rows.n_px = n_px;
    rows.per_px = per_px;
    for (Made& each : rows.made) each.row = INT64_MIN;
  }
  const std::int64_t j = std::llround((y + 0.5) * per_px - 0.5) + below;
  Made& row = rows.made[static_cast<std::size_t>(j & 3)];
  if (row.row == j) return row;
  row.row = j;
  const double at = (static_cast<double>(j) + 0.5) / per_px - 0.5;
  if (silver_.spreads()) {
    silver_.field(at, first_px, n_px, per_px, row.silver);
  } else {
    silver_.behind_sets(at, first_px, n_px, per_px, row.silver);
  }
  if (painter_ != nullptr) silver_.areas(at, first_px, n_px, per_px, row.areas);
  return row;
}

void ScreenFilm::join_rows(double y, Rows& rows, const CellRow& out) const {
  const int per_px = out.per_px();
  const double cell = 1.0 / per_px;
  const bool coarse = per_px > 1 && per_px <= kCellsThatNeedIt && strip_.on_film(y - cell) &&
                      strip_.on_film(y + cell);
  // In ascending order, as the rings of the emulsion like it.
  const Made* const above = coarse ? &made(rows, y, -1, out) : nullptr;
  const Made& here = made(rows, y, 0, out);
  const Made* const below = coarse ? &made(rows, y, 1, out) : nullptr;
  const int n_sets = painter_ == nullptr ? 1 : static_cast<int>(painter_->sets().size());
  const auto n = static_cast<std::size_t>(out.n_px());
  // A scene without fine detail is known at the middles of cells; a field is a mean already.
  const float bend = !silver_.spreads() && !strip_.has_fine_detail() ? 1.0F / 24 : 0.0F;
  rows.light.resize(out.first_px(), out.n_px(), per_px, n_sets);
  for (int k = 0; k < n_sets; ++k) {
    const auto silver = [&](const Made& row, int s) {
      return row.silver.phase(silver_.spreads() ? 0 : k, s) + kBlockPx;
    };
    const auto area = [k](const Made& row, int s) { return row.areas.phase(k, s) + kBlockPx; };
    for (int s = 0; s < per_px; ++s) {
      float* const to = rows.light.phase(k, s);
      std::copy_n(silver(here, s), n, to);
      if (coarse) {
        const float *const t = silver(here, s), *const t0 = silver(*above, s),
                           *const t1 = silver(*below, s);
        for (std::size_t i = 0; i < n; ++i) to[i] += bend * (t0[i] - 2 * t[i] + t1[i]);
      }
      if (painter_ == nullptr) continue;
      const float* const a = area(here, s);
      for (std::size_t i = 0; i < n; ++i) to[i] *= a[i];
      if (!coarse) continue;
      // Gradient times gradient / 12, each half a difference over two cells. The cells left and
      // right may belong to the neighbouring pixel.
      const int left = s == 0 ? per_px - 1 : s - 1, right = s + 1 == per_px ? 0 : s + 1;
      const int from_left = s == 0 ? 1 : 0, from_right = s + 1 == per_px ? 1 : 0;
      add_products(area(*above, s), area(*below, s), silver(*above, s), silver(*below, s), n, to);
      add_products(area(here, left) - from_left, area(here, right) + from_right,
                   silver(here, left) - from_left, silver(here, right) + from_right, n, to);
    }
  }
}

void ScreenFilm::mix(double y, Rows& rows, CellRow& out) const {
  const auto n = static_cast<std::size_t>(out.n_px());
  rows.silver.assign(n * static_cast<std::size_t>(out.per_px()), 0.0F);
  for (int c = 0; c < kChannels; ++c) {
    std::fill_n(out.phase(c, 0), rows.silver.size(), 0.0F);
  }
  if (painter_ == nullptr) {
    const float* silver = rows.light.plane(0);
    std::copy_n(silver, rows.silver.size(), rows.silver.data());
    for (int c = 0; c < kChannels; ++c) std::copy_n(silver, rows.silver.size(), out.phase(c, 0));
    return;
  }
  const bool fades = damage_.has_faded();
  if (fades) {
    rows.faded.resize(n);
    damage_.faded(y, std::min(film_x(out.first_px()), film_x(out.first_px() + out.n_px() - 1)),
                  rows.faded);
    if (spec_.mirrored) std::ranges::reverse(rows.faded);
  }
  for (std::size_t k = 0; k < painter_->sets().size(); ++k) {
    const auto set = static_cast<std::size_t>(painter_->sets()[k]);
    std::array<float, 4> p{}, more{};  // response, and what full fading adds to it
    for (std::size_t c = 0; c < 4; ++c) {
      p[c] = static_cast<float>(response_[set][c]);
      more[c] = static_cast<float>(faded_response_[set][c] - response_[set][c]);
    }
    for (int s = 0; s < out.per_px(); ++s) {
      const float* of_set = rows.light.phase(static_cast<int>(k), s);
      float* silver = rows.silver.data() + static_cast<std::size_t>(s) * n;
      float *r = out.phase(0, s), *g = out.phase(1, s), *b = out.phase(2, s), *i = out.phase(3, s);
      const float* faded = fades ? rows.faded.data() : nullptr;
      for (std::size_t x = 0; x < n; ++x) {
        const float light = of_set[x];
        silver[x] += light;
        r[x] += light * p[0];
        g[x] += light * p[1];
        b[x] += light * p[2];
        i[x] += light * p[3];
      }
      if (faded == nullptr) continue;
      for (std::size_t x = 0; x < n; ++x) {
        const float light = of_set[x] * faded[x];
        r[x] += light * more[0];
        g[x] += light * more[1];
        b[x] += light * more[2];
        i[x] += light * more[3];
      }
    }
  }
}

void ScreenFilm::apply_grain(double y, Rows& rows, CellRow& out) const {
  const auto n = static_cast<std::size_t>(out.n_px());
  const auto per = static_cast<std::size_t>(out.per_px());
  // The field runs along the film cell after cell, the row is kept by phases.
  thread_local std::vector<float> in_order;
  in_order.resize(n * per);
  rows.factor.resize(n * per);
  for (std::size_t s = 0; s < per; ++s) {
    for (std::size_t x = 0; x < n; ++x) in_order[x * per + s] = rows.silver[s * n + x];
  }
  const double x0 = film_x(out.first_px() + cell_offset_px(0, out.per_px()));
  grain_.factors(y, x0, direction() / out.per_px(), in_order, rows.factor);
  for (std::size_t s = 0; s < per; ++s) {
    for (std::size_t x = 0; x < n; ++x) in_order[s * n + x] = rows.factor[x * per + s];
  }
  for (int c = 0; c < kChannels; ++c) {
    float* to = out.phase(c, 0);
    for (std::size_t x = 0; x < n * per; ++x) to[x] *= in_order[x];
  }
}

void ScreenFilm::apply_damage(double y, Rows& rows, CellRow& out) const {
  constexpr float kDarkest = 0.003F;  // silver that a scratch still uncovers
  const auto n = static_cast<std::size_t>(out.n_px());
  const auto per = static_cast<std::size_t>(out.per_px());
  if (damage_.has_stains()) {
    rows.stain.resize(n);
    damage_.stained(y, std::min(film_x(out.first_px()), film_x(out.first_px() + out.n_px() - 1)),
                    rows.stain);
    if (spec_.mirrored) std::ranges::reverse(rows.stain);
    for (std::size_t c = 0; c < 3; ++c) {
      for (int s = 0; s < out.per_px(); ++s) {
        float* to = out.phase(static_cast<int>(c), s);
        for (std::size_t x = 0; x < n; ++x) to[x] *= 1 - Damage::kStain[c] * rows.stain[x];
      }
    }
  }
  if (!damage_.has_local()) return;
  rows.transmittance.resize(n * per);
  rows.bared.resize(n * per);
  const double x0 = film_x(out.first_px() + cell_offset_px(0, out.per_px()));
  if (!damage_.local(y, x0, direction() / out.per_px(), {rows.transmittance, rows.bared})) return;
  for (std::size_t s = 0; s < per; ++s) {
    for (std::size_t x = 0; x < n; ++x) {
      const float bared = rows.bared[x * per + s];
      const float silver = std::max(rows.silver[s * n + x], kDarkest);
      const float factor = rows.transmittance[x * per + s] * (1 + bared * (1 / silver - 1));
      for (int c = 0; c < kChannels; ++c) out.phase(c, 0)[s * n + x] *= factor;
    }
  }
}

void ScreenFilm::apply_film_edge(CellRow& out) const {
  const double cell = 1.0 / out.per_px();
  const double left = spec_.frame.outside_px - 0.5;
  const double right = spec_.frame.width_px - 0.5 - spec_.frame.outside_px;
  for (int s = 0; s < out.per_px(); ++s) {
    for (int i = 0; i < out.n_px(); ++i) {
      const double x = out.first_px() + i + cell_offset_px(s, out.per_px());
      if (x > left + cell && x < right - cell) continue;
      const float film = part_below(right, x, cell) - part_below(left, x, cell);
      for (int c = 0; c < kChannels; ++c) {
        float& value = out.phase(c, s)[i];
        value = 1 + film * (value - 1);
      }
    }
  }
}

void ScreenFilm::harm_row(double y, double x0, std::span<float> out) const {
  std::ranges::fill(out, 0.0F);
  std::vector<float> transmittance(out.size()), bared(out.size());
  if (!damage_.local(y, film_x(x0), direction(), {transmittance, bared})) return;
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i] = std::max(1 - transmittance[i], bared[i]);
  }
}

}  // namespace reseau::sim
