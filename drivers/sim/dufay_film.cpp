#include "drivers/sim/dufay_film.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/base/check.h"

namespace reseau::sim {
namespace {

// Mean of a half plane over a square cell. With the cell projected on the gradient of a coordinate
// s, the mean is a ramp: the convolution of two boxes as wide as the two projected sides.
class EdgeRamp {
 public:
  // s_x, s_y: change of s over one cell along x and y.
  EdgeRamp(double s_x, double s_y) {
    const double wide = std::max(std::abs(s_x), std::abs(s_y));
    // A box narrower than this is a step for float arithmetic.
    const double narrow = std::max(std::min(std::abs(s_x), std::abs(s_y)), 0.002 * wide);
    outer_ = static_cast<float>((wide + narrow) / 2);
    inner_ = static_cast<float>((wide - narrow) / 2);
    gain_ = static_cast<float>(1 / (2 * wide * narrow));
  }
  // Mean of (s > 0) over a cell with s = d at its centre.
  [[nodiscard]] float operator()(float d) const {
    d = d > -outer_ ? d : -outer_;
    d = d < outer_ ? d : outer_;
    return gain_ * (square(d + outer_) - square(d + inner_) - square(d - inner_));
  }

 private:
  static float square(float t) {
    t = t > 0.0F ? t : 0.0F;
    return t * t;
  }
  float outer_, inner_, gain_;
};

float from_nearest_integer(float t) {  // t > 0
  const auto k = static_cast<float>(static_cast<int>(t + 0.5F));
  return t > k ? t - k : k - t;
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

}  // namespace

ElementResponse element_response(double fade) {
  // Per unit of infrared, from a 4000 dpi LS-9000 scan with all four channels.
  constexpr ElementResponse kFresh{{{1.25, 0.16, 0.16}, {0.08, 1.01, 0.46}, {0.07, 0.21, 0.77}}};
  constexpr double kLargest = 1.25;
  ElementResponse result{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double grey = (kFresh[k][0] + kFresh[k][1] + kFresh[k][2]) / 3;
    for (std::size_t c = 0; c < 3; ++c) {
      result[k][c] = ((1 - fade) * kFresh[k][c] + fade * grey) / kLargest;
    }
  }
  return result;
}

DufayFilm::DufayFilm(const FilmSpec& spec)
    : strip_(spec), screen_(spec.screen, spec.frame), response_(element_response(spec.fade)) {}

ScreenPoint DufayFilm::screen_from_scan(double x, double y) const {
  return screen_.screen_from_film(strip_.film_from_scan(x, y));
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
  const ScreenGradient& g = screen_.gradient();
  const EdgeRamp ramp_u(g.u_x * cell, g.u_y * cell), ramp_v(g.v_x * cell, g.v_y * cell);
  const auto red_begins = static_cast<float>(0.5 - screen_.spec().red_fraction / 2);
  const auto green_ends = static_cast<float>(screen_.spec().green_fraction / 2);
  float p[3][3];
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t c = 0; c < 3; ++c) p[k][c] = static_cast<float>(response_[k][c]);
  }

  ScreenPoint from = screen_from_scan(first_px, y);
  for (int block = 0; block < n_px; block += kBlockPx) {
    const ScreenPoint to = screen_from_scan(first_px + block + kBlockPx, y);
    // Within a block (0.1 mm) the réseau is straight; whole periods are taken off in double
    // precision and a few are added so that every value stays positive.
    const double base_u = from.u - std::floor(from.u) + 8, step_u = (to.u - from.u) / kBlockPx;
    const double base_v = from.v - std::floor(from.v) + 8, step_v = (to.v - from.v) / kBlockPx;
    const auto du = static_cast<float>(step_u), dv = static_cast<float>(step_v);
    for (int s = 0; s < per_px; ++s) {
      const double offset = (s + 0.5) * cell - 0.5;
      const auto u0 = static_cast<float>(base_u + step_u * offset);
      const auto v0 = static_cast<float>(base_v + step_v * offset);
      // Silver at pixel i + offset lies between two of its neighbours.
      const int left = offset < 0 ? block : block + 1;
      const auto right_weight = static_cast<float>(offset < 0 ? 1 + offset : offset);
      const float* tr = silver.r.data() + left;
      const float* tg = silver.g.data() + left;
      const float* tb = silver.b.data() + left;
      float* out_r = out.phase(0, s) + block;
      float* out_g = out.phase(1, s) + block;
      float* out_b = out.phase(2, s) + block;
      float* out_i = out.phase(3, s) + block;
      for (int i = 0; i < kBlockPx; ++i) {
        const auto fi = static_cast<float>(i);
        const float red = ramp_v(from_nearest_integer(v0 + fi * dv) - red_begins);
        const float in_green = ramp_u(green_ends - from_nearest_integer(u0 + fi * du));
        const float green = (1.0F - red) * in_green;
        const float blue = 1.0F - red - green;
        const float r = red * (tr[i] + right_weight * (tr[i + 1] - tr[i]));
        const float gr = green * (tg[i] + right_weight * (tg[i + 1] - tg[i]));
        const float b = blue * (tb[i] + right_weight * (tb[i + 1] - tb[i]));
        out_r[i] = r * p[0][0] + gr * p[1][0] + b * p[2][0];
        out_g[i] = r * p[0][1] + gr * p[1][1] + b * p[2][1];
        out_b[i] = r * p[0][2] + gr * p[1][2] + b * p[2][2];
        out_i[i] = r + gr + b;
      }
    }
    from = to;
  }
}

void PlainFilm::cells(double y, int first_px, int n_px, int per_px, CellRow& out) const {
  out.resize(first_px, n_px, per_px);
  thread_local SilverRow silver;
  silver.read(strip_, y, first_px, n_px);
  for (std::size_t i = 0; i < silver.r.size(); ++i) {
    silver.r[i] = 0.30F * silver.r[i] + 0.59F * silver.g[i] + 0.11F * silver.b[i];
  }
  for (int s = 0; s < per_px; ++s) {
    const double offset = (s + 0.5) / per_px - 0.5;
    const float* t = silver.r.data() + (offset < 0 ? 0 : 1);
    const auto right_weight = static_cast<float>(offset < 0 ? 1 + offset : offset);
    for (int i = 0; i < n_px; ++i) {
      const float value = t[i] + right_weight * (t[i + 1] - t[i]);
      for (int c = 0; c < kChannels; ++c) out.phase(c, s)[i] = value;
    }
  }
}

Film::Extent NoFilm::extent() const {
  constexpr int kFar = 1 << 28;
  return {-kFar, kFar};
}

void NoFilm::cells(double /*y*/, int first_px, int n_px, int per_px, CellRow& out) const {
  out.resize(first_px, n_px, per_px);
  fill(out, 1.0F);
}

std::unique_ptr<Film> make_film(const FilmSpec& spec) {
  switch (spec.kind) {
    case FilmKind::kDufay:
      return std::make_unique<DufayFilm>(spec);
    case FilmKind::kPlain:
      return std::make_unique<PlainFilm>(spec);
    case FilmKind::kEmpty:
      break;
  }
  return std::make_unique<NoFilm>();
}

}  // namespace reseau::sim
