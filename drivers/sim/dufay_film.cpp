#include "drivers/sim/dufay_film.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/base/check.h"
#include "drivers/sim/edge_ramp.h"
#include "drivers/sim/film/edge_directions.h"

namespace reseau::sim {
namespace {

float from_nearest_integer(float t) {  // t > 0
  // NOLINTNEXTLINE(bugprone-incorrect-roundings): t > 0, and lround would cost a call per cell
  const auto k = static_cast<float>(static_cast<int>(t + 0.5F));
  return std::abs(t - k);
}

// Silver at pixels first - 1 … first + n, so that cells between pixels can be interpolated.
struct SilverRow {
  std::vector<float> r, g, b;
  void read(const FilmStrip& strip, double y, int first_px, int n_px) {
    const auto n = static_cast<std::size_t>(n_px) + 2;
    r.resize(n);
    g.resize(n);
    b.resize(n);
    strip.silver_row(y, first_px - 1.0, {r, g, b});
  }
};

void fill(CellRow& out, float value) {
  for (int c = 0; c < kChannels; ++c) {
    for (int s = 0; s < out.per_px(); ++s) std::fill_n(out.phase(c, s), out.n_px(), value);
  }
}

// One block of cells a pixel apart: silver at the pixels left of them, and where they lie.
struct BlockIn {
  const float *silver_r, *silver_g, *silver_b;
  float right_weight;  // of the pixel to the right, in interpolating the silver
  float u, u_step, v, v_step;
};

// From places on the screen to transmittances.
class CellPattern {
 public:
  CellPattern(const PlacedScreen& screen, const ElementResponse& response, double cell_px)
      : ramp_u_(screen.gradient().u_x * cell_px, screen.gradient().u_y * cell_px),
        ramp_v_(screen.gradient().v_x * cell_px, screen.gradient().v_y * cell_px),
        red_begins_(static_cast<float>(0.5 - screen.spec().red_fraction / 2)),
        green_ends_(static_cast<float>(screen.spec().green_fraction / 2)) {
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t c = 0; c < 3; ++c) p_[k][c] = static_cast<float>(response[k][c]);
    }
  }

  // kBlockPx cells; the outputs overlap nothing.
  void render(const BlockIn& in, float* __restrict out_r, float* __restrict out_g,
              float* __restrict out_b, float* __restrict out_i) const {
    for (int i = 0; i < kBlockPx; ++i) {
      const auto fi = static_cast<float>(i);
      const float red = ramp_v_(from_nearest_integer(in.v + fi * in.v_step) - red_begins_);
      const float in_green = ramp_u_(green_ends_ - from_nearest_integer(in.u + fi * in.u_step));
      const float green = (1.0F - red) * in_green;
      const float blue = 1.0F - red - green;
      const float r = red * between(in.silver_r, i, in.right_weight);
      const float g = green * between(in.silver_g, i, in.right_weight);
      const float b = blue * between(in.silver_b, i, in.right_weight);
      out_r[i] = r * p_[0][0] + g * p_[1][0] + b * p_[2][0];
      out_g[i] = r * p_[0][1] + g * p_[1][1] + b * p_[2][1];
      out_b[i] = r * p_[0][2] + g * p_[1][2] + b * p_[2][2];
      out_i[i] = r + g + b;
    }
  }

 private:
  static float between(const float* silver, int i, float right_weight) {
    return silver[i] + right_weight * (silver[i + 1] - silver[i]);
  }
  EdgeRamp ramp_u_, ramp_v_;
  float red_begins_, green_ends_;
  float p_[3][3];
};

}  // namespace

DufayFilm::DufayFilm(const FilmSpec& spec)
    : strip_(spec),
      screen_(spec),
      response_(element_response(spec.dyes.fade)),
      edges_off_axes_deg_(sim::edges_off_axes_deg(spec)) {}

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
  thread_local SilverRow silver;
  silver.read(strip_, y, first_px, n_px);

  const double cell = 1.0 / per_px;
  const CellPattern pattern(screen_, response_, cell);
  ScreenPoint from = screen_.screen_from_scan(first_px, y);
  for (int block = 0; block < n_px; block += kBlockPx) {
    const ScreenPoint to = screen_.screen_from_scan(first_px + block + kBlockPx, y);
    // Within a block (0.1 mm) the réseau is straight; whole periods are taken off in double
    // precision and a few are added so that every value stays positive.
    const double base_u = from.u - std::floor(from.u) + 8, step_u = (to.u - from.u) / kBlockPx;
    const double base_v = from.v - std::floor(from.v) + 8, step_v = (to.v - from.v) / kBlockPx;
    for (int s = 0; s < per_px; ++s) {
      const double offset = (s + 0.5) * cell - 0.5;
      const auto u0 = static_cast<float>(base_u + step_u * offset);
      const auto v0 = static_cast<float>(base_v + step_v * offset);
      // Silver at pixel i + offset lies between two of its neighbours.
      const int left = offset < 0 ? block : block + 1;
      const auto right_weight = static_cast<float>(offset < 0 ? 1 + offset : offset);
      const BlockIn in{silver.r.data() + left,
                       silver.g.data() + left,
                       silver.b.data() + left,
                       right_weight,
                       u0,
                       static_cast<float>(step_u),
                       v0,
                       static_cast<float>(step_v)};
      pattern.render(in, out.phase(0, s) + block, out.phase(1, s) + block, out.phase(2, s) + block,
                     out.phase(3, s) + block);
    }
    from = to;
  }
}

}  // namespace reseau::sim
