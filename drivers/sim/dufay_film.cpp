#include "drivers/sim/dufay_film.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/check.h"
#include "drivers/sim/edge_ramp.h"
#include "drivers/sim/film/edge_directions.h"
#include "drivers/sim/widest.h"

namespace reseau::sim {
namespace {

std::uint64_t next_film() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

float from_nearest_integer(float t) {  // t > 0
  // NOLINTNEXTLINE(bugprone-incorrect-roundings): t > 0, and lround would cost a call per cell
  const auto k = static_cast<float>(static_cast<int>(t + 0.5F));
  return t - k;
}

// Silver at pixels first - 1 … first + n, so that cells between pixels can be interpolated.
using SilverRow = std::array<std::vector<float>, 3>;

// Rows of silver at the grid of cells, the latest four: each is its neighbours' neighbour.
class SilverRows {
 public:
  void prepare(std::uint64_t film, int first_px, int n_px, int per_px) {
    if (film_ == film && first_px_ == first_px && n_px_ == n_px && per_px_ == per_px) return;
    film_ = film;
    first_px_ = first_px;
    n_px_ = n_px;
    per_px_ = per_px;
    row_in_slot_.fill(INT64_MIN);
  }
  // The row of cells nearest to y, or `below` rows from it.
  const SilverRow& at(const FilmStrip& strip, double y, int below) {
    const std::int64_t j = std::llround((y + 0.5) * per_px_ - 0.5) + below;
    const auto slot = static_cast<std::size_t>(j & 3);
    SilverRow& row = rows_[slot];
    if (row_in_slot_[slot] != j) {
      row_in_slot_[slot] = j;
      for (auto& color : row) color.resize(static_cast<std::size_t>(n_px_) + 2);
      strip.silver_row((static_cast<double>(j) + 0.5) / per_px_ - 0.5, first_px_ - 1.0,
                       {row[0], row[1], row[2]});
    }
    return row;
  }

 private:
  std::uint64_t film_ = 0;
  int first_px_ = 0, n_px_ = 0, per_px_ = 0;
  std::array<std::int64_t, 4> row_in_slot_{};
  std::array<SilverRow, 4> rows_;
};

// What silver is over the height of a cell, from its values at the middles of three rows of cells:
// the mean, and the change from edge to edge.
struct SilverOfCells {
  SilverRow mean, along_y;
  void set(const SilverRow& above, const SilverRow& here, const SilverRow& below, float cell_px,
           bool tents) {
    const float bend = tents ? 1.0F / 12 : 1.0F / 24;
    // Between pixels the silver is straight: even cells lie in one such part, tents reach over.
    const float bend_x = tents ? cell_px * cell_px / 24 : 0.0F;
    for (std::size_t k = 0; k < 3; ++k) {
      mean[k].resize(here[k].size());
      along_y[k].resize(here[k].size());
      for (std::size_t i = 0; i < here[k].size(); ++i) {
        const float a = above[k][i], h = here[k][i], b = below[k][i];
        along_y[k][i] = 0.5F * (b - a);
        mean[k][i] = h + (a - 2 * h + b) * bend;
      }
      for (std::size_t i = 1; bend_x > 0 && i + 1 < here[k].size(); ++i) {
        mean[k][i] += bend_x * (here[k][i - 1] - 2 * here[k][i] + here[k][i + 1]);
      }
    }
  }
};

// Whether the silver of a block changes at all: otherwise its product with an element is that of
// their means.
bool changes(const SilverRow& silver, const SilverRow& along_y, int block, float cell_px) {
  float most = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const float *s = silver[k].data() + block, *d = along_y[k].data() + block;
    for (int i = 0; i <= kBlockPx; ++i) {
      most = std::max({most, cell_px * std::abs(s[i + 1] - s[i]), std::abs(d[i])});
    }
  }
  return most > 0;
}

void fill(CellRow& out, float value) {
  for (int c = 0; c < kChannels; ++c) {
    for (int s = 0; s < out.per_px(); ++s) std::fill_n(out.phase(c, s), out.n_px(), value);
  }
}

// One block of cells a pixel apart: silver at the pixels left of them, and where they lie.
struct BlockIn {
  std::array<const float*, 3> silver, along_y;  // R G B, and their change over a cell along y
  float right_weight;  // of the pixel to the right, in interpolating the silver
  float u, u_step, v, v_step;
};

// From places on the screen to transmittances.
class CellPattern {
 public:
  CellPattern(const ScreenSpec& screen, const ScreenGradient& gradient,
              const ElementResponse& response, double cell_px, bool tents)
      : cell_px_(static_cast<float>(cell_px)),
        u_x_(static_cast<float>(gradient.u_x * cell_px)),
        u_y_(static_cast<float>(gradient.u_y * cell_px)),
        v_x_(static_cast<float>(gradient.v_x * cell_px)),
        v_y_(static_cast<float>(gradient.v_y * cell_px)),
        variance_(tents ? 1.0F / 6 : 1.0F / 12),
        tents_(tents),
        ramp_u_(tents ? EdgeRamp::tent(u_x_, u_y_) : EdgeRamp(u_x_, u_y_)),
        ramp_v_(tents ? EdgeRamp::tent(v_x_, v_y_) : EdgeRamp(v_x_, v_y_)),
        part_u_(u_x_ / kParts, u_y_ / kParts),
        part_v_(v_x_ / kParts, v_y_ / kParts),
        red_begins_(static_cast<float>(0.5 - screen.red_fraction / 2)),
        green_ends_(static_cast<float>(screen.green_fraction / 2)) {
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t c = 0; c < 3; ++c) p_[k][c] = static_cast<float>(response[k][c]);
    }
  }

  // kBlockPx cells; the outputs overlap nothing. `together`: with what element and silver change
  // together within the cell; otherwise the silver is even enough.
  template <bool together>
  RESEAU_SIM_INLINE void render(const BlockIn& in, float* __restrict out_r, float* __restrict out_g,
                                float* __restrict out_b, float* __restrict out_i) const {
    float area[3][kBlockPx], du[kBlockPx], dv[kBlockPx], meet[kBlockPx];
    for (int i = 0; i < kBlockPx; ++i) {
      const auto fi = static_cast<float>(i);
      dv[i] = from_nearest_integer(in.v + fi * in.v_step);
      du[i] = from_nearest_integer(in.u + fi * in.u_step);
      const float red = ramp_v_(std::abs(dv[i]) - red_begins_);
      const float in_green = ramp_u_(green_ends_ - std::abs(du[i]));
      area[0][i] = red;
      area[1][i] = (1.0F - red) * in_green;
      area[2][i] = 1.0F - red - area[1][i];
      meet[i] = red * (1.0F - red) * in_green * (1.0F - in_green);
    }
    for (int i = 0; i < kBlockPx; ++i) {
      if (meet[i] > kMeet) divide(du[i], dv[i], i, area);
    }
    // Into arrays that nothing else points to, or compilers take no vectors for it.
    float light[3][kBlockPx];
    for (int i = 0; i < kBlockPx; ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        light[k][i] = area[k][i] * between(in.silver[k], i, in.right_weight);
      }
      if constexpr (together) {
        // Mean of a product less the product of the means: gradient times gradient x variance.
        const float in_red = std::abs(dv[i]) - red_begins_;
        const float past_green = green_ends_ - std::abs(du[i]);
        const float red = ramp_v_(in_red), in_green = ramp_u_(past_green);
        const float to_red = std::copysign(ramp_v_.slope(in_red), dv[i]) * variance_;
        const float to_green =
            -std::copysign(ramp_u_.slope(past_green), du[i]) * variance_ * (1.0F - red);
        light[0][i] += to_red * along(in, 0, i, v_x_, v_y_);
        light[1][i] += to_green * along(in, 1, i, u_x_, u_y_) -
                       to_red * in_green * along(in, 1, i, v_x_, v_y_);
        light[2][i] += -to_green * along(in, 2, i, u_x_, u_y_) -
                       to_red * (1.0F - in_green) * along(in, 2, i, v_x_, v_y_);
      }
    }
    for (int i = 0; i < kBlockPx; ++i) {
      const float r = light[0][i], g = light[1][i], b = light[2][i];
      out_r[i] = r * p_[0][0] + g * p_[1][0] + b * p_[2][0];
      out_g[i] = r * p_[0][1] + g * p_[1][1] + b * p_[2][1];
      out_b[i] = r * p_[0][2] + g * p_[1][2] + b * p_[2][2];
      out_i[i] = r + g + b;
    }
  }

 private:
  // Where two edges cross, their shares of a cell do not multiply: that is done in its parts.
  static constexpr int kParts = 4;
  static constexpr float kMeet = 1e-6F;
  __attribute__((noinline)) void divide(float du, float dv, int cell,
                                        float (*area)[kBlockPx]) const {
    // A tent is two cells wide.
    const int side = tents_ ? 2 * kParts : kParts;
    float sum = 0, sum_red = 0, sum_green = 0;
    for (int part = 0; part < side * side; ++part) {
      const int row = part / side;
      const float x =
          (static_cast<float>(part % side) + 0.5F - 0.5F * static_cast<float>(side)) / kParts;
      const float y = (static_cast<float>(row) + 0.5F - 0.5F * static_cast<float>(side)) / kParts;
      const float u = du + x * u_x_ + y * u_y_, v = dv + x * v_x_ + y * v_y_;
      const float weight = tents_ ? (1 - std::abs(x)) * (1 - std::abs(y)) : 1.0F;
      const float red = part_v_(std::abs(v) - red_begins_);
      sum += weight;
      sum_red += weight * red;
      sum_green += weight * (1.0F - red) * part_u_(green_ends_ - std::abs(u));
    }
    area[0][cell] = sum_red / sum;
    area[1][cell] = sum_green / sum;
    area[2][cell] = 1.0F - area[0][cell] - area[1][cell];
  }
  static float between(const float* silver, int i, float right_weight) {
    return silver[i] + right_weight * (silver[i + 1] - silver[i]);
  }
  // Change of the silver along the gradient of a screen coordinate (per cell).
  [[nodiscard]] float along(const BlockIn& in, std::size_t k, int i, float s_x, float s_y) const {
    return s_x * cell_px_ * (in.silver[k][i + 1] - in.silver[k][i]) +
           s_y * between(in.along_y[k], i, in.right_weight);
  }
  float cell_px_, u_x_, u_y_, v_x_, v_y_;
  float variance_;  // of a cell's weight along either axis [cells^2]
  bool tents_;
  EdgeRamp ramp_u_, ramp_v_, part_u_, part_v_;  // of a cell, of a part of it
  float red_begins_, green_ends_;
  float p_[3][3];
};

}  // namespace

DufayFilm::DufayFilm(const FilmSpec& spec)
    : strip_(spec),
      screen_(spec),
      response_(element_response(spec.dyes.fade)),
      edges_(edges_of(spec)),
      strained_(screen_.largest_strain() > 0.004),
      id_(next_film()) {}

bool DufayFilm::can_render(const FilmSpec& spec) {
  const PrintSpec& print = spec.print;
  const DamageSpec& harm = spec.damage;
  constexpr double kStraightPx = 2e-3;  // that the réseau may leave a line within a block
  return spec.kind == FilmKind::kDufay && is_dufaycolor(spec.screen.kind) && !spec.general_path &&
         (spec.scene == SceneKind::kChart || spec.scene == SceneKind::kNatural) &&
         PlacedScreen(spec).largest_curvature() * kBlockPx * kBlockPx / 8 < kStraightPx &&
         spec.dyes.source == DyeSource::kMeasured && spec.dyes.infrared_leak == 0 &&
         spec.emulsion.spread_um == 0 && spec.emulsion.silver_spread_um == 0 &&
         spec.emulsion.grain == 0 && print.overlap_um == 0 && print.position_noise_um == 0 &&
         print.width_noise_um == 0 && print.missing == 0 && harm.dust_per_cm2 == 0 &&
         harm.scratches_per_cm == 0 && harm.bubbles_per_cm2 == 0 && harm.faded_areas == 0 &&
         harm.stains == 0 && spec.frame.outside_px == 0;
}

void DufayFilm::cells(double y, int first_px, int n_px, int per_px, CellRow& out) const {
  CHECK(first_px % kBlockPx == 0 && n_px % kBlockPx == 0 && per_px >= 1);
  out.resize(first_px, n_px, per_px);
  if (!strip_.on_film(y)) {
    fill(out, 1.0F);
    return;
  }
  const double cell = 1.0 / per_px;
  thread_local SilverRows rows;
  thread_local SilverOfCells of_cells;
  rows.prepare(id_, first_px, n_px, per_px);
  const bool coarse = per_px > 1 && strip_.on_film(y - cell) && strip_.on_film(y + cell);
  if (coarse) {
    of_cells.set(rows.at(strip_, y, -1), rows.at(strip_, y, 0), rows.at(strip_, y, 1),
                 static_cast<float>(cell), out.tents());
  }
  const SilverRow& silver = coarse ? of_cells.mean : rows.at(strip_, y, 0);
  const SilverRow& along_y = of_cells.along_y;

  CellPattern pattern(screen_.spec(), screen_.scan_gradient(), response_, cell, out.tents());
  ScreenPoint from = screen_.screen_from_scan(first_px, y);
  for (int block = 0; block < n_px; block += kBlockPx) {
    const ScreenPoint to = screen_.screen_from_scan(first_px + block + kBlockPx, y);
    if (strained_) {
      const double x = first_px + block + (kBlockPx - 1) / 2.0;
      const ScreenPoint above = screen_.screen_from_scan(x, y - 1),
                        below = screen_.screen_from_scan(x, y + 1);
      pattern = CellPattern(screen_.spec(),
                            {(to.u - from.u) / kBlockPx, (below.u - above.u) / 2,
                             (to.v - from.v) / kBlockPx, (below.v - above.v) / 2},
                            response_, cell, out.tents());
    }
    // Within a block (0.1 mm) the réseau is straight; whole periods are taken off in double
    // precision and a few are added so that every value stays positive.
    const double base_u = from.u - std::floor(from.u) + 8, step_u = (to.u - from.u) / kBlockPx;
    const double base_v = from.v - std::floor(from.v) + 8, step_v = (to.v - from.v) / kBlockPx;
    const bool together = coarse && changes(silver, along_y, block, static_cast<float>(cell));
    for (int s = 0; s < per_px; ++s) {
      const double offset = (s + 0.5) * cell - 0.5;
      const auto u0 = static_cast<float>(base_u + step_u * offset);
      const auto v0 = static_cast<float>(base_v + step_v * offset);
      // Silver at pixel i + offset lies between two of its neighbours.
      const int left = offset < 0 ? block : block + 1;
      const auto right_weight = static_cast<float>(offset < 0 ? 1 + offset : offset);
      const auto from_left = [left](const SilverRow& row) {
        return std::array<const float*, 3>{row[0].data() + left, row[1].data() + left,
                                           row[2].data() + left};
      };
      const BlockIn in{from_left(silver),
                       together ? from_left(along_y) : std::array<const float*, 3>{},
                       right_weight,
                       u0,
                       static_cast<float>(step_u),
                       v0,
                       static_cast<float>(step_v)};
      float *const r = out.phase(0, s) + block, *const g = out.phase(1, s) + block,
                   *const b = out.phase(2, s) + block, *const i = out.phase(3, s) + block;
      if (together) {
        widest([&]() RESEAU_SIM_INLINE { pattern.render<true>(in, r, g, b, i); });
      } else {
        widest([&]() RESEAU_SIM_INLINE { pattern.render<false>(in, r, g, b, i); });
      }
    }
    from = to;
  }
}

}  // namespace reseau::sim
