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
#include "drivers/sim/smooth_step.h"
#include "drivers/sim/widest.h"

namespace reseau::sim {
namespace {

DyeSpec faded_dyes(DyeSpec dyes) {
  dyes.fade += (1 - dyes.fade) * Damage::kWorstFade;
  return dyes;
}

constexpr int kMostLevels = 3;         // of cells divided by 2 along each side
constexpr int kMostLevelsOfTents = 2;  // divided by 3
constexpr int kRuns = 8;               // of divided cells along a row that keep what they know

std::uint64_t next_film() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

}  // namespace

// Rows of tents, summed along x to tents that are wider by a number of parts: the latest few, for
// tents of neighbouring rows of cells have rows of parts in common.
struct ScreenFilm::JoinedTents {
  std::uint64_t film = 0;
  bool harm = false;
  CellRange cells;
  int parts = 1;
  std::array<std::int64_t, 32> row_in_slot{};
  std::array<CellRow, 32> slots;

  void prepare(std::uint64_t of_film, bool with_harm, const CellRange& range, int n_parts) {
    if (film == of_film && harm == with_harm && cells == range && parts == n_parts) return;
    film = of_film;
    harm = with_harm;
    cells = range;
    parts = n_parts;
    row_in_slot.fill(INT64_MIN);
  }
  // By how much the k-th part from the middle counts.
  [[nodiscard]] float weight(int k) const {
    return static_cast<float>(parts - std::abs(k)) / static_cast<float>(parts * parts);
  }
  void join(const CellRow& fine, CellRow& to) const;
};

struct ScreenFilm::Rows {
  LightRows light;
  CellRow fine;  // cells that were divided
  JoinedTents joined;
  std::vector<float> faded, stain;
  std::vector<float> whole, share;  // cells as they were before, what they still count
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
  // What elements and silver change together is taken from the cells around.
  constexpr double kSmallFrame = 3e5;
  const double frame_px = 1.0 * spec.frame.width_px * spec.frame.height_px * spec.frame.n_frames;
  const bool small = frame_px < kSmallFrame, gaps = spec.print.overlap_um < 0;
  // Twelve are summed at three to a px, for spread light less exact than ten are. A zone plate is
  // fine over much of its field.
  const bool fine = spec.scene == SceneKind::kZone || (small && spec.scene == SceneKind::kStar);
  edges_.fewest_tents = edges_.spreads && gaps ? 10 : gaps || fine ? 12 : 8;
  // Specks have edges of their own.
  constexpr double kManySpecks = 300;  // per cm^2
  if (damage_.has_local()) {
    edges_.fewest_tents = small ? 16 : spec.damage.dust_per_cm2 > kManySpecks ? 14 : 12;
  }
}

double ScreenFilm::height_um(double x, double /*y*/) const { return screen_.height_um(x); }

ScreenFilm::Rows& ScreenFilm::rows_of_thread(int level, int run) {
  thread_local std::array<std::array<Rows, kRuns>, kMostLevels + 1> rows;
  return rows[static_cast<std::size_t>(level)][static_cast<std::size_t>(run % kRuns)];
}

FilmLayers ScreenFilm::layers() const {
  return {strip_, painter_.get(), silver_, &grain_, &damage_, spec_.mirrored, id_};
}

void ScreenFilm::cells(double y, int first_px, int n_px, int per_px, CellRow& out) const {
  CHECK(first_px % kBlockPx == 0 && n_px % kBlockPx == 0 && per_px >= 1);
  out.resize(first_px, n_px, per_px);
  render_divided(y, true, out);
  if (!strip_.on_film(y)) return;
  if (damage_.has_stains()) apply_stains(y, rows_of_thread(0, 0), out);
  if (spec_.frame.outside_px > 0) apply_film_edge(out);
}

void ScreenFilm::silver_cells(double y, int first_px, int n_px, int per_px, CellRow& out) const {
  CHECK(first_px % kBlockPx == 0 && n_px % kBlockPx == 0 && per_px >= 1);
  out.resize(first_px, n_px, per_px);
  render_divided(y, false, out);
}

void ScreenFilm::render(double y, bool harm, Rows& rows, CellRow& out) const {
  if (!strip_.on_film(y)) {
    for (int c = 0; c < kChannels; ++c) {
      std::fill_n(out.phase(c, 0), out.n_px() * out.per_px(), 1.0F);
    }
    return;
  }
  const FilmLayers film = layers();
  mix(y, rows.light.row(film, y, {out.first_px(), out.n_px(), out.per_px(), out.tents()}, harm),
      rows, out);
}

int ScreenFilm::level_at(double y, int px, const CellRow& cells) const {
  const double x0 = px - 0.5, x1 = x0 + kBlockPx;
  const int most = cells.tents() ? kMostLevelsOfTents : kMostLevels;
  const int parts = cells.tents() ? 3 : 2;
  // Steps lie within cells of any size.
  const int steps_at = strip_.has_steps() ? FilmStrip::kWholeCellsAt : cells.per_px();
  double whole = FilmStrip::kWholeCells * steps_at / FilmStrip::kWholeCellsAt;
  const double finest = strip_.finest_cy_per_px(y, x0, x1);
  int level = 0;
  for (; level < most && finest > whole; ++level) whole *= parts;
  // The ends of border and rebate are steeper than any scene; tents are exact enough.
  const bool steep = !cells.tents() && cells.per_px() <= FilmStrip::kWholeCellsAt;
  return steep && strip_.near_frame(y, x0, x1) ? std::max(level, 1) : level;
}

void ScreenFilm::render_divided(double y, bool harm, CellRow& out) const {
  const int per_px = out.per_px();
  // Maps of stray light need no more than their cells. Silver that spreads is smooth, and its layer
  // divides the exposure.
  const bool divides = per_px > 2 && painter_ != nullptr && !silver_.spreads();
  render(y, harm, rows_of_thread(0, 0), out);
  if (!divides || !strip_.on_film(y)) return;
  const auto level_of = [&](int block) { return level_at(y, out.first_px() + block, out); };
  std::array<int, kMostLevels + 1> n_runs{};
  for (int begin = 0; begin < out.n_px();) {
    const int level = level_of(begin);
    int end = begin + kBlockPx;
    while (end < out.n_px() && level_of(end) == level) end += kBlockPx;
    if (level > 0) {
      Rows& rows = rows_of_thread(level, n_runs[static_cast<std::size_t>(level)]++);
      if (out.tents()) {
        keep_whole({begin, end}, rows, out);
        divide_tents(y, level == 1 ? 3 : 9, harm, {begin, end}, rows, out);
        fade_to_whole(y, {begin, end}, rows, out);
      } else {
        divide_even(y, 1 << level, harm, {begin, end}, rows, out);
      }
    }
    begin = end;
  }
}

void ScreenFilm::keep_whole(PixelRun run, Rows& rows, const CellRow& out) const {
  rows.whole.clear();
  if (strip_.has_steps()) return;
  for (int c = 0; c < kChannels; ++c) {
    for (int s = 0; s < out.per_px(); ++s) {
      const float* const from = out.phase(c, s);
      rows.whole.insert(rows.whole.end(), from + run.begin, from + run.end);
    }
  }
}

// Errors of whole cells even out under the lens, but not at a line at which they end.
void ScreenFilm::fade_to_whole(double y, PixelRun run, Rows& rows, CellRow& out) const {
  if (rows.whole.empty()) return;
  constexpr double kOver = 0.1;
  const double whole = FilmStrip::kWholeCells * out.per_px() / FilmStrip::kWholeCellsAt;
  const int n = run.end - run.begin;
  rows.share.resize(static_cast<std::size_t>(n));
  bool fades = false;
  for (int i = 0; i < n; ++i) {
    const double x = out.first_px() + run.begin + i;
    const double finest = strip_.finest_cy_per_px(y, x - 0.5, x + 0.5);
    const double share = std::clamp(1 - (finest - whole) / (kOver * whole), 0.0, 1.0);
    rows.share[static_cast<std::size_t>(i)] = static_cast<float>(share);
    fades = fades || share > 0;
  }
  const float* from = rows.whole.data();
  for (int c = 0; c < kChannels && fades; ++c) {
    for (int s = 0; s < out.per_px(); ++s, from += n) {
      float* const to = out.phase(c, s) + run.begin;
      for (int i = 0; i < n; ++i)
        to[i] += rows.share[static_cast<std::size_t>(i)] * (from[i] - to[i]);
    }
  }
}

void ScreenFilm::divide_even(double y, int parts, bool harm, PixelRun run, Rows& rows,
                             CellRow& out) const {
  const int per_px = out.per_px(), n = run.end - run.begin;
  CellRow& fine = rows.fine;
  fine.set_tents(false);
  fine.resize(out.first_px() + run.begin, n, per_px * parts);
  const auto share = static_cast<float>(1.0 / (parts * parts));
  for (int j = 0; j < parts; ++j) {
    render(y + ((j + 0.5) / parts - 0.5) / per_px, harm, rows, fine);
    for (int c = 0; c < kChannels; ++c) {
      for (int s = 0; s < per_px; ++s) {
        float* const to = out.phase(c, s) + run.begin;
        if (j == 0) std::fill_n(to, n, 0.0F);
        for (int k = 0; k < parts; ++k) {
          const float* const from = fine.phase(c, s * parts + k);
          for (int i = 0; i < n; ++i) to[i] += share * from[i];
        }
      }
    }
  }
}

// fine reaches a pixel farther on both sides.
void ScreenFilm::JoinedTents::join(const CellRow& fine, CellRow& to) const {
  to.resize(cells.first_px, cells.n_px, cells.per_px);
  for (int c = 0; c < kChannels; ++c) {
    for (int s = 0; s < cells.per_px; ++s) {
      float* const sum = to.phase(c, s);
      std::fill_n(sum, cells.n_px, 0.0F);
      for (int k = 1 - parts; k < parts; ++k) {
        const int at = s * parts + (parts - 1) / 2 + k;
        const int carry = at < 0 ? -1 : at >= fine.per_px() ? 1 : 0;
        const float* const from = fine.phase(c, at - carry * fine.per_px()) + 1 + carry;
        const float share = weight(k);
        for (int i = 0; i < cells.n_px; ++i) sum[i] += share * from[i];
      }
    }
  }
}

// A tent is a sum of tents of a part of its side, 3 of them with weights 1 2 3 2 1.
void ScreenFilm::divide_tents(double y, int parts, bool harm, PixelRun run, Rows& rows,
                              CellRow& out) const {
  const int per_px = out.per_px(), fine_per_px = per_px * parts, n = run.end - run.begin;
  const CellRange cells{out.first_px() + run.begin, n, per_px, true};
  JoinedTents& joined = rows.joined;
  joined.prepare(id_, harm, cells, parts);
  const std::int64_t middle = std::llround((y + 0.5) * per_px - 0.5) * parts + (parts - 1) / 2;
  for (int j = 1 - parts; j < parts; ++j) {
    const std::int64_t row = middle + j;
    const auto slot = static_cast<std::size_t>(row & 31);
    CellRow& of_row = joined.slots[slot];
    if (joined.row_in_slot[slot] != row) {
      rows.fine.set_tents(true);
      rows.fine.resize(cells.first_px - 1, n + 2, fine_per_px);
      render((static_cast<double>(row) + 0.5) / fine_per_px - 0.5, harm, rows, rows.fine);
      joined.join(rows.fine, of_row);
      joined.row_in_slot[slot] = row;
    }
    const float share = joined.weight(j);
    for (int c = 0; c < kChannels; ++c) {
      for (int s = 0; s < per_px; ++s) {
        float* const to = out.phase(c, s) + run.begin;
        if (j == 1 - parts) std::fill_n(to, n, 0.0F);
        const float* const from = of_row.phase(c, s);
        for (int i = 0; i < n; ++i) to[i] += share * from[i];
      }
    }
  }
}

void ScreenFilm::mix(double y, const PlaneRow& light_of, Rows& rows, CellRow& out) const {
  const auto n = static_cast<std::size_t>(out.n_px());
  if (painter_ == nullptr) {
    for (int c = 0; c < kChannels; ++c) {
      std::copy_n(light_of.plane(0), light_of.plane_size(), out.phase(c, 0));
    }
    return;
  }
  const bool fades = damage_.has_faded();
  if (fades) {
    rows.faded.resize(n);
    damage_.faded(y, std::min(film_x(out.first_px()), film_x(out.first_px() + out.n_px() - 1)),
                  rows.faded);
    if (spec_.mirrored) std::ranges::reverse(rows.faded);
  }
  // Response of every set, and what full fading adds to it.
  const std::size_t n_sets = painter_->sets().size();
  std::array<std::array<float, 4>, kDyeSets> response{}, more{};
  for (std::size_t k = 0; k < n_sets; ++k) {
    const auto set = static_cast<std::size_t>(painter_->sets()[k]);
    for (std::size_t c = 0; c < 4; ++c) {
      response[k][c] = static_cast<float>(response_[set][c]);
      more[k][c] = static_cast<float>(faded_response_[set][c] - response_[set][c]);
    }
  }
  for (int s = 0; s < out.per_px(); ++s) {
    for (int c = 0; c < kChannels; ++c) {
      const auto channel = static_cast<std::size_t>(c);
      float* const to = out.phase(c, s);
      // Three sets at a time, as most screens have.
      for (std::size_t k = 0; k < n_sets; k += 3) {
        std::array<const float*, 3> of{};
        std::array<float, 3> p{};
        for (std::size_t t = 0; t < 3; ++t) {
          const std::size_t set = std::min(k + t, n_sets - 1);
          of[t] = light_of.phase(static_cast<int>(set), s);
          p[t] = k + t < n_sets ? response[set][channel] : 0.0F;
        }
        const bool first = k == 0;
        widest([&]() RESEAU_SIM_INLINE {
          float* __restrict const sum = to;
          const float *const a = of[0], *const b = of[1], *const d = of[2];
          const float pa = p[0], pb = p[1], pd = p[2];
          if (first) {
            for (std::size_t x = 0; x < n; ++x) sum[x] = (a[x] * pa + b[x] * pb) + d[x] * pd;
          } else {
            for (std::size_t x = 0; x < n; ++x) sum[x] += (a[x] * pa + b[x] * pb) + d[x] * pd;
          }
        });
      }
      for (std::size_t k = 0; fades && k < n_sets; ++k) {
        const float* const light = light_of.phase(static_cast<int>(k), s);
        const float by = more[k][channel];
        for (std::size_t x = 0; x < n; ++x) to[x] += light[x] * rows.faded[x] * by;
      }
    }
  }
}

void ScreenFilm::apply_stains(double y, Rows& rows, CellRow& out) const {
  const auto n = static_cast<std::size_t>(out.n_px());
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

// Cut with a slant: the film ends softly, so that its end is known wherever it lies.
void ScreenFilm::apply_film_edge(CellRow& out) const {
  constexpr double kCutPx = 2;
  const double left = spec_.frame.outside_px - 0.5;
  const double right = spec_.frame.width_px - 0.5 - spec_.frame.outside_px;
  const int per_px = out.per_px(), n = out.n_px() * per_px;
  const double cell = 1.0 / per_px;
  const float variance = out.tents() ? 1.0F / 6 : 1.0F / 12;
  const auto film_at = [&](double x) {
    return smooth_step(static_cast<float>(std::min(x - left, right - x) / kCutPx));
  };
  std::array<float, kChannels> before{};  // the cell to the left, as it was
  for (int k = 0; k < n; ++k) {
    const int i = k / per_px, s = k % per_px, after = std::min(k + 1, n - 1);
    const double x = out.first_px() + i + cell_offset_px(s, per_px);
    const bool whole = x > left + kCutPx && x < right - kCutPx;
    const float here = whole ? 1 : film_at(x);
    const float film0 = whole ? 1 : film_at(x - cell), film1 = whole ? 1 : film_at(x + cell);
    for (int c = 0; c < kChannels; ++c) {
      float& value = out.phase(c, s)[i];
      const float was = value, next = out.phase(c, after % per_px)[after / per_px];
      float& left_of_it = before[static_cast<std::size_t>(c)];
      if (k == 0) left_of_it = was;
      if (!whole) {
        // Means of film and value, and what both change together.
        value = 1 + (here + (film0 + film1 - 2 * here) * variance / 2) * (was - 1) +
                (film1 - film0) * (next - left_of_it) * variance / 4;
      }
      left_of_it = was;
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
