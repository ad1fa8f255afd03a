#include "drivers/sim/film/grain.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "drivers/sim/hash.h"
#include "drivers/sim/spline_weights.h"
#include "drivers/sim/widest.h"

namespace reseau::sim {
namespace {

constexpr double kDensest = 3.5;  // more density has no more grain

// Sum of four uniform numbers, of unit variance.
float normal(std::uint64_t bits) {
  const auto sum = static_cast<float>((bits & 0xffff) + (bits >> 16 & 0xffff) +
                                      (bits >> 32 & 0xffff) + (bits >> 48));
  return (sum / 65536.0F - 2.0F) * 1.7320508F;
}

// exp(x), |x| < 40, relative error below 4e-6; the compiler makes vector code of it.
inline float fast_exp(float x) {
  const float t = x * 1.44269504F + 127.0F;
  const auto whole = static_cast<std::int32_t>(t);
  const float f = t - static_cast<float>(whole) - 0.5F;  // -0.5 … 0.5
  // 2^(f + 0.5)
  const float p = 1.41421356F +
                  f * (0.98025814F +
                       f * (0.33973160F + f * (0.07849467F + f * (0.01360209F + f * 0.00188565F))));
  return p * std::bit_cast<float>(whole << 23);
}

// Root of x >= 0, relative error below 1e-6; the library's may set errno, which keeps vectors away.
inline float fast_root(float x) {
  float inverse = std::bit_cast<float>(0x5f3759df - (std::bit_cast<std::int32_t>(x) >> 1));
  for (int k = 0; k < 3; ++k) inverse *= 1.5F - 0.5F * x * inverse * inverse;
  return x * inverse;
}

// log2(x), x > 0, within 2e-6: the compiler makes vector code of it.
inline float fast_log2(float x) {
  const auto bits = std::bit_cast<std::int32_t>(x);
  const std::int32_t exponent = (bits - 0x3f3504f3) >> 23;  // the rest is 0.707 … 1.414
  const float m = std::bit_cast<float>(bits - (exponent << 23));
  const float t = (m - 1) / (m + 1), t2 = t * t;
  const float p = t * (2.88539008F + t2 * (0.96179669F + t2 * (0.57707802F + t2 * 0.4121F)));
  return static_cast<float>(exponent) + p;
}

// Correlation of the field with itself `lag` knots away along one axis, of cubic splines: the
// B-spline of degree 7, at most 4 knots.
double correlation(double lag) {
  constexpr int kSteps = 400;
  const auto spline = [](double t) {
    t = std::abs(t);
    if (t >= 2) return 0.0;
    return t >= 1 ? (2 - t) * (2 - t) * (2 - t) / 6 : 2.0 / 3 - t * t + t * t * t / 2;
  };
  double sum = 0, whole = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double t = -2 + 4 * (i + 0.5) / kSteps;
    sum += spline(t) * spline(t - lag);
    whole += spline(t) * spline(t);
  }
  return sum / whole;
}

// Variance of the mean over a square pixel of exp(q n - q^2 / 2) - 1, whose covariance at a lag is
// exp(q^2 correlation) - 1; and that of n itself.
struct PixelVariance {
  double texture = 0, field = 0;
  PixelVariance(double knot_px, double q) {
    constexpr int kSteps = 96;
    std::array<double, kSteps> at{}, weight{};
    for (int i = 0; i < kSteps; ++i) {
      const double lag = (i + 0.5) / kSteps;  // of a pixel
      at[static_cast<std::size_t>(i)] = correlation(lag / knot_px);
      weight[static_cast<std::size_t>(i)] = 2 * (1 - lag) / kSteps;
    }
    for (std::size_t i = 0; i < kSteps; ++i) {
      for (std::size_t j = 0; j < kSteps; ++j) {
        texture += weight[i] * weight[j] * std::expm1(q * q * at[i] * at[j]);
        field += weight[i] * weight[j] * at[i] * at[j];
      }
    }
  }
};

std::uint64_t next_id() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

struct KnotRows {
  std::uint64_t id = 0;
  std::int64_t first = 0;
  std::size_t n = 0;
  std::array<std::int64_t, 4> row{INT64_MIN, INT64_MIN, INT64_MIN, INT64_MIN};
  std::array<std::vector<float>, 4> values;
  std::vector<float> mixed;
};

}  // namespace

Grain::Grain(double amount, double knot_px, std::uint64_t seed)
    : amount_(amount), knot_px_(knot_px), seed_(seed), id_(next_id()) {
  constexpr double kSplineVariance = 151.0 / 315;  // integral of the squared cubic B-spline
  gain_ = 1 / kSplineVariance;                     // the root of both axes
  pixel_rms_ = std::sqrt(PixelVariance(knot_px, 0).field);
  if (amount == 0) return;
  // As skewed as it has to be for the densest silver to stay positive.
  constexpr double kLargest = 2.0;
  const double most = amount * std::sqrt(kDensest);
  const double q = std::min(std::sqrt(std::log1p(most * most)) / pixel_rms_, kLargest);
  contrast_ = static_cast<float>(q);
  const double rms = std::sqrt(PixelVariance(knot_px, q).texture);
  per_depth_ = static_cast<float>(amount / rms * std::sqrt(std::numbers::ln2 / std::numbers::ln10));
}

void Grain::knot_row(std::int64_t iy, std::int64_t first, std::span<float> out) const {
  const std::uint64_t key = mix64(seed_, static_cast<std::uint64_t>(iy));
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i] = normal(mix64(key, static_cast<std::uint64_t>(first) + i));
  }
}

void Grain::field(double y, double x0, double step_px, std::span<float> out) const {
  if (out.empty()) return;
  thread_local KnotRows rows;
  const double ty = y / knot_px_;
  const auto iy = static_cast<std::int64_t>(std::floor(ty));
  const std::array<double, 4> wy = spline_weights(ty - static_cast<double>(iy));
  const double last_x = x0 + step_px * static_cast<double>(out.size() - 1);
  const auto first = static_cast<std::int64_t>(std::floor(std::min(x0, last_x) / knot_px_));
  const auto end = static_cast<std::int64_t>(std::floor(std::max(x0, last_x) / knot_px_)) + 4;
  const auto n = static_cast<std::size_t>(end - first);
  if (rows.id != id_ || rows.first != first || rows.n != n) {
    rows.id = id_;
    rows.first = first;
    rows.n = n;
    rows.row.fill(INT64_MIN);
  }
  rows.mixed.assign(n, 0.0F);
  for (std::int64_t j = 0; j < 4; ++j) {
    const std::int64_t row = iy + j;
    const auto slot = static_cast<std::size_t>(row & 3);
    if (rows.row[slot] != row) {
      rows.values[slot].resize(n);
      knot_row(row, first, rows.values[slot]);
      rows.row[slot] = row;
    }
    const auto w = static_cast<float>(wy[static_cast<std::size_t>(j)] * gain_);
    const float* from = rows.values[slot].data();
    for (std::size_t i = 0; i < n; ++i) rows.mixed[i] += w * from[i];
  }
  const double per_px = 1 / knot_px_;
  const double at0 = x0 * per_px - static_cast<double>(first), step = step_px * per_px;
  const float* const c = rows.mixed.data();
  float* const to = out.data();
  const std::size_t n_out = out.size();
  widest([&]() RESEAU_SIM_INLINE {
    float* __restrict const values = to;
    for (std::size_t i = 0; i < n_out; ++i) {
      const double at = at0 + step * static_cast<double>(static_cast<std::int32_t>(i));
      const auto k = static_cast<std::int32_t>(at);
      const auto f = static_cast<float>(at - static_cast<double>(k));
      const float g = 1 - f, f2 = f * f, g2 = g * g;
      values[i] = (g2 * g * c[k] + (3 * f2 * f - 6 * f2 + 4) * c[k + 1] +
                   (3 * g2 * g - 6 * g2 + 4) * c[k + 2] + f2 * f * c[k + 3]) *
                  (1.0F / 6);
    }
  });
}

void Grain::texture(double y, double x0, double step_px, std::span<float> out) const {
  field(y, x0, step_px, out);
  const float q = contrast_, half = 0.5F * q * q;
  float* const to = out.data();
  const std::size_t n = out.size();
  widest([&]() RESEAU_SIM_INLINE {
    for (std::size_t i = 0; i < n; ++i) to[i] = fast_exp(q * to[i] - half) - 1;
  });
}

void Grain::depths(std::span<const float> silver, std::span<float> depth) const {
  constexpr auto kThinnest = static_cast<float>(kDensest / 0.301029996);  // as a power of 2
  const float* const t = silver.data();
  float* const to = depth.data();
  const float a = per_depth_;
  const std::size_t n = silver.size();
  widest([&]() RESEAU_SIM_INLINE {
    float* __restrict const out = to;
    for (std::size_t i = 0; i < n; ++i) {
      const float light = std::abs(t[i]) + 1e-9F;  // none is negative
      float stops = -fast_log2(light);
      // Clamped to 0 … kThinnest by absolute values, which compilers have vector code for.
      stops = 0.5F * (kThinnest + std::abs(stops) - std::abs(stops - kThinnest));
      const float share = a * fast_root(stops);
      out[i] = t[i] * 0.5F * (share + 1 - std::abs(share - 1));
    }
  });
}

}  // namespace reseau::sim
