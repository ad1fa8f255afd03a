// Test targets with detail finer than a pixel: every sample is the mean over its cell.
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <numbers>
#include <vector>

#include "drivers/sim/edge_ramp.h"
#include "drivers/sim/scene.h"
#include "drivers/sim/smooth_step.h"
#include "drivers/sim/widest.h"

namespace reseau::sim {
namespace {

constexpr double kMean = 0.5, kAmplitude = 0.45;

// Series of sin(a) / a for a^2 = t up to this, to 1e-10.
constexpr double kShort = 0.9;
template <typename T>
RESEAU_SIM_INLINE inline void short_sinc(const T& t, T& to) {
  to = 1 - t * (1.0 / 6) *
               (1 - t * (1.0 / 20) *
                        (1 - t * (1.0 / 42) * (1 - t * (1.0 / 72) * (1 - t * (1.0 / 110)))));
}

// Four doubles, a notation both compilers have.
using D4 = double __attribute__((vector_size(32)));

// 1 / sqrt(t) to the last bits by Newton's steps from a guess by the exponent: compilers take no
// vectors for roots, which may set errno.
RESEAU_SIM_INLINE inline void inverse_root(const D4& t, D4& r) {
  using Bits = std::uint64_t __attribute__((vector_size(32)));
  Bits bits;
  std::memcpy(&bits, &t, sizeof bits);
  bits = 0x5fe6eb50c7b537a9ULL - (bits >> 1);
  std::memcpy(&r, &bits, sizeof r);
  for (int k = 0; k < 4; ++k) r *= 1.5 - 0.5 * t * r * r;
}

double sinc(double x) {
  const double a = std::numbers::pi * x, t = a * a;
  if (t >= kShort) return std::sin(a) / a;
  double value = 0;
  short_sinc(t, value);
  return value;
}

class FineScene : public Scene {
 public:
  void row(double y, double x0, const RgbRow& out) const override { cells(y, x0, 1.0, out); }
  [[nodiscard]] bool has_fine_detail() const override { return true; }
};

class ZoneScene final : public FineScene {
 public:
  ZoneScene(double width_px, double height_px, double finest)
      : cx_((width_px - 1) / 2),
        cy_((height_px - 1) / 2),
        per_px_(finest / (std::min(width_px, height_px) / 2)) {}

  void cells(double y, double x0, double side_px, const RgbRow& out) const override {
    means(y, x0, side_px, 0, out);
  }
  // A tent is the mean of the cells around: along either axis of two, by Gauss's rule.
  void tents(double y, double x0, double side_px, const RgbRow& out) const override {
    means(y, x0, side_px, side_px * std::sqrt(1.0 / 12), out);
  }

  // Of cells so far to both sides.
  void means(double y, double x0, double side_px, double off_px, const RgbRow& out) const {
    // The phase is a sum of one part in x and one in y: so is the exponent's mean a product.
    struct Across {
      std::array<double, 5> made_for{};
      std::vector<std::complex<double>> wave;
    };
    thread_local std::array<Across, 8> kept;  // rows are asked for at a few places in turn
    thread_local std::size_t oldest = 0;
    const std::array<double, 5> wanted{per_px_, x0 - cx_, side_px, off_px,
                                       static_cast<double>(out.r.size())};
    const auto mean = [&](double t) {
      return off_px == 0
                 ? mean_of_chirp(t, side_px)
                 : 0.5 * (mean_of_chirp(t - off_px, side_px) + mean_of_chirp(t + off_px, side_px));
    };
    auto found = std::ranges::find(kept, wanted, &Across::made_for);
    const bool known = found != kept.end();
    if (!known) found = kept.begin() + static_cast<std::ptrdiff_t>(oldest++ % kept.size());
    std::vector<std::complex<double>>& across = found->wave;
    if (!known) {
      found->made_for = wanted;
      across.resize(out.r.size());
      for (std::size_t i = 0; i < across.size(); ++i) {
        across[i] = mean(x0 + static_cast<double>(i) * side_px - cx_);
      }
    }
    const std::complex<double> down = mean(y - cy_);
    for (std::size_t i = 0; i < out.r.size(); ++i) {
      const double wave = down.real() * across[i].real() - down.imag() * across[i].imag();
      out.r[i] = out.g[i] = out.b[i] = static_cast<float>(kMean + kAmplitude * wave);
    }
  }
  [[nodiscard]] double finest_cy_per_px(double y, double x0, double x1) const override {
    const double x = std::max(std::abs(x0 - cx_), std::abs(x1 - cx_));
    return per_px_ * std::hypot(x, y - cy_);
  }

 private:
  // Of exp(i pi per_px t^2) from t - side / 2 to t + side / 2: Gauss and Legendre's rule on pieces
  // that hold less than half a cycle, to 1e-9.
  [[nodiscard]] std::complex<double> mean_of_chirp(double t, double side) const {
    static constexpr std::array<double, 3> kNode{0, 0.5384693101056831, 0.9061798459386640};
    static constexpr std::array<double, 3> kWeight{0.2844444444444444, 0.2393143352496832,
                                                   0.1184634425280945};
    const int pieces = 1 + static_cast<int>(2 * per_px_ * (std::abs(t) + side / 2) * side);
    std::complex<double> sum;
    for (int k = 0; k < pieces; ++k) {
      const double half = side / (2 * pieces), middle = t - side / 2 + (2 * k + 1) * half;
      for (std::size_t j = 0; j < kNode.size(); ++j) {
        for (const double sign : {-1.0, 1.0}) {
          if (j == 0 && sign > 0) continue;
          const double at = middle + sign * kNode[j] * half;
          sum += kWeight[j] * std::polar(1.0, std::numbers::pi * per_px_ * at * at);
        }
      }
    }
    return sum / static_cast<double>(pieces);
  }

  double cx_, cy_, per_px_;  // centre; growth of the frequency [cycles/px/px]
};

class StarScene final : public FineScene {
 public:
  StarScene(double width_px, double height_px, int spokes)
      : cx_((width_px - 1) / 2),
        cy_((height_px - 1) / 2),
        spokes_(spokes),
        disc_px_(std::max(spokes / (2 * std::numbers::pi * kFinest), 1.0)) {}

  void cells(double y, double x0, double side_px, const RgbRow& out) const override {
    means(y, x0, side_px, false, out);
  }
  void tents(double y, double x0, double side_px, const RgbRow& out) const override {
    means(y, x0, side_px, true, out);
  }

  // The transfer function of a tent is that of a cell, squared.
  void means(double y, double x0, double side_px, bool tents, const RgbRow& out) const {
    // Beyond this radius spokes are straight over a cell and coarse against it, and have begun.
    const double dy = y - cy_;
    const double straight = side_px * std::sqrt(spokes_ / (8 * kLargestCurvature));
    const double coarse = spokes_ * side_px / (2 * std::sqrt(kShort));
    const double far = std::max({disc_px_ * (1 + kFade) + 2 * side_px, straight, coarse});
    const double half = std::sqrt(std::max(far * far - dy * dy, 0.0));
    const double off = tents ? side_px * std::sqrt(1.0 / 12) : 0;
    const std::size_t n = out.r.size();
    for (std::size_t i = 0; i < n; i += kChunk) {
      const std::span<float> to = out.r.subspan(i, std::min(kChunk, n - i));
      far_waves(x0 + static_cast<double>(i) * side_px - cx_, dy, side_px, tents, to);
    }
    const auto cell_at = [&](double dx) {
      const double at = std::ceil((cx_ + dx - x0) / side_px);
      return static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(n)));
    };
    for (std::size_t i = cell_at(-half), end = cell_at(half); i < end; ++i) {
      const double dx = x0 + static_cast<double>(i) * side_px - cx_;
      double wave = 0;
      if (tents) {
        for (const double x : {dx - off, dx + off}) {
          for (const double down : {dy - off, dy + off}) {
            wave += 0.25 * mean_wave(x, down, side_px, kDeepest);
          }
        }
      } else {
        wave = mean_wave(dx, dy, side_px, kDeepest);
      }
      out.r[i] = static_cast<float>(kMean + kAmplitude * wave);
    }
    std::ranges::copy(out.r, out.g.begin());
    std::ranges::copy(out.r, out.b.begin());
  }
  [[nodiscard]] double finest_cy_per_px(double y, double x0, double x1) const override {
    const double x = std::max({x0 - cx_, cx_ - x1, 0.0});
    return spokes_ / (2 * std::numbers::pi * std::max(std::hypot(x, y - cy_), 0.8 * disc_px_));
  }

 private:
  static constexpr int kDeepest = 6;
  static constexpr double kFinest = 1.5;  // cycles per px, where the spokes end at an even disc
  static constexpr double kFade = 0.4;    // of the disc's radius, over which they end
  static constexpr double kLargestCurvature = 0.002;  // [radian] that the phase leaves a plane
  static constexpr std::size_t kChunk = 256;
  // mean_wave() where nothing has to be divided, of at most kChunk cells. The cosine of so many
  // times an angle is the real part of a power, which squaring makes.
  void far_waves(double dx0, double dy, double side, bool tents, std::span<float> out) const {
    std::array<float, kChunk> values{};
    const std::size_t n = out.size();
    const int spokes = spokes_;
    const double waves = spokes * side / 2;  // x pi: phase of a cell's side at distance 1
    const double power = tents ? 1 : 0;
    float* const to = values.data();
    // Eight at a time stay in registers.
    widest([=]() RESEAU_SIM_INLINE {
      const D4 step{0, side, 2 * side, 3 * side};
      for (std::size_t first = 0; first < n; first += 8) {
        D4 a[2], b[2], softened[2], x[2], y[2];
        for (std::size_t k = 0; k < 2; ++k) {
          const D4 dx = step + (dx0 + static_cast<double>(first + 4 * k) * side);
          D4 per_r;
          inverse_root(dx * dx + dy * dy + 1e-12, per_r);
          a[k] = dx * per_r;
          b[k] = dy * per_r;
          const D4 over_x = waves * a[k] * per_r, over_y = waves * b[k] * per_r;
          D4 once, along_y;
          short_sinc(over_x * over_x, once);
          short_sinc(over_y * over_y, along_y);
          once *= along_y;
          softened[k] = once + power * (once * once - once);
          x[k] = D4{} + 1.0;
          y[k] = D4{};
        }
        for (int left = spokes; left > 0; left /= 2) {
          for (std::size_t k = 0; k < 2; ++k) {
            if (left % 2 != 0) {
              const D4 product = x[k] * a[k] - y[k] * b[k];
              y[k] = y[k] * a[k] + x[k] * b[k];
              x[k] = product;
            }
            const D4 squared = a[k] * a[k] - b[k] * b[k];
            b[k] = 2 * a[k] * b[k];
            a[k] = squared;
          }
        }
        for (std::size_t k = 0; k < 2; ++k) {
          const D4 wave = kMean + kAmplitude * x[k] * softened[k];
          for (std::size_t j = 0; j < 4; ++j) to[first + 4 * k + j] = static_cast<float>(wave[j]);
        }
      }
    });
    std::copy_n(values.begin(), n, out.begin());
  }
  // Of the cosine over a square: value times transfer function where the spokes are straight over
  // the square, else the mean of its quarters.
  [[nodiscard]] double mean_wave(double dx, double dy, double side, int depth) const {
    const double r2 = dx * dx + dy * dy;
    const double r = std::sqrt(r2), fade_px = kFade * disc_px_;
    if (r + side < disc_px_ - fade_px / 2) return 0;
    const bool fades = r - side < disc_px_ + fade_px / 2;
    if (spokes_ * side * side / 8 <= kLargestCurvature * r2 && !(fades && side > 0.1 * fade_px)) {
      const double cy_per_px = spokes_ / (2 * std::numbers::pi * r2);  // times r
      const double begun =
          fades ? static_cast<double>(smooth_step(static_cast<float>((r - disc_px_) / fade_px)))
                : 1.0;
      return begun * std::cos(spokes_ * std::atan2(dy, dx)) * sinc(cy_per_px * dy * side) *
             sinc(cy_per_px * dx * side);
    }
    if (depth == 0) return 0;  // many spokes within the square, or its share of the middle
    const double q = side / 4, half = side / 2;
    return 0.25 * (mean_wave(dx - q, dy - q, half, depth - 1) +
                   mean_wave(dx + q, dy - q, half, depth - 1) +
                   mean_wave(dx - q, dy + q, half, depth - 1) +
                   mean_wave(dx + q, dy + q, half, depth - 1));
  }
  double cx_, cy_;
  int spokes_;
  double disc_px_;  // radius of the middle
};

struct TwoColours {
  std::array<float, 3> left, right;
};
constexpr int kColumns = 3, kRows = 2;
constexpr std::array<TwoColours, 6> kFields{{
    {{0.04F, 0.04F, 0.04F}, {0.90F, 0.90F, 0.90F}},
    {{0.60F, 0.05F, 0.05F}, {0.05F, 0.45F, 0.08F}},
    {{0.05F, 0.45F, 0.08F}, {0.05F, 0.08F, 0.60F}},
    {{0.05F, 0.08F, 0.60F}, {0.60F, 0.05F, 0.05F}},
    {{0.30F, 0.30F, 0.30F}, {0.75F, 0.37F, 0.03F}},
    {{0.05F, 0.60F, 0.60F}, {0.60F, 0.05F, 0.05F}},
}};
constexpr float kGround = 0.20F;
constexpr double kMargin = 0.06;  // of a field, on every side
constexpr float kFieldEdgePx = 3.0F;

class EdgesScene final : public FineScene {
 public:
  EdgesScene(double width_px, double height_px, double angle_deg)
      : field_w_(width_px / kColumns),
        field_h_(height_px / kRows),
        angle_deg_(angle_deg),
        across_x_(std::cos(angle_deg * std::numbers::pi / 180)),
        across_y_(-std::sin(angle_deg * std::numbers::pi / 180)) {}

  void cells(double y, double x0, double side_px, const RgbRow& out) const override {
    means(y, x0, side_px, EdgeRamp(across_x_ * side_px, across_y_ * side_px), 1.0F / 24, out);
  }
  void tents(double y, double x0, double side_px, const RgbRow& out) const override {
    const EdgeRamp ramp = EdgeRamp::tent(across_x_ * side_px, across_y_ * side_px);
    means(y, x0, side_px, ramp, 1.0F / 12, out);
  }

  // Over cells that see the border so, and from second differences the ends of a field.
  void means(double y, double x0, double side_px, const EdgeRamp& ramp, float bend,
             const RgbRow& out) const {
    const int field_row = std::clamp(static_cast<int>(std::floor(y / field_h_)), 0, kRows - 1);
    const double centre_y = (field_row + 0.5) * field_h_;
    const float wy = window(y - field_row * field_h_, field_h_, side_px, bend);
    const std::array<std::span<float>, 3> bands{out.r, out.g, out.b};
    const std::size_t n = out.r.size();
    std::size_t begin = 0;
    for (int column = 0; column < kColumns; ++column) {
      const double next = ((column + 1) * field_w_ - x0) / side_px;
      const std::size_t end =
          column + 1 == kColumns
              ? n
              : static_cast<std::size_t>(std::clamp(std::ceil(next), 0.0, static_cast<double>(n)));
      const TwoColours& colours = kFields[field_index(column, field_row)];
      const double left = x0 - column * field_w_, down = across_y_ * (y - centre_y);
      thread_local std::vector<float> share;  // of the colour to the right of the border
      share.resize(n);
      float* const right = share.data();
      const double side = side_px, half = field_w_ / 2, across = across_x_;
      widest([&]() RESEAU_SIM_INLINE {
        float* __restrict const to = right;
        for (std::size_t i = begin; i < end; ++i) {
          const double local_x = left + static_cast<double>(static_cast<int>(i)) * side;
          to[i] = ramp(static_cast<float>(across * (local_x - half) + down));
        }
      });
      for (std::size_t k = 0; k < 3; ++k) {
        const float from = colours.left[k], change = colours.right[k] - from;
        float* const band = bands[k].data();
        widest([&]() RESEAU_SIM_INLINE {
          float* __restrict const to = band;
          for (std::size_t i = begin; i < end; ++i) {
            to[i] = kGround + wy * (from + right[i] * change - kGround);
          }
        });
      }
      // The ends of the field are soft.
      const auto soft = [&](std::size_t i) {
        const double local_x = left + static_cast<double>(i) * side_px;
        const float w = window(local_x, field_w_, side_px, bend);
        for (std::size_t k = 0; k < 3 && w != 1; ++k) {
          bands[k][i] = kGround + w * (bands[k][i] - kGround);
        }
        return w != 1;
      };
      std::size_t first = begin;
      while (first < end && soft(first)) ++first;
      for (std::size_t i = end; i > first && soft(i - 1); --i) {
      }
      begin = std::max(begin, end);
    }
  }

  // A step has detail of any frequency; this much is worth dividing the cells along it once.
  [[nodiscard]] double finest_cy_per_px(double y, double x0, double x1) const override {
    const int field_row = std::clamp(static_cast<int>(std::floor(y / field_h_)), 0, kRows - 1);
    const double dy = y - (field_row + 0.5) * field_h_;
    for (int column = 0; column < kColumns; ++column) {
      const double x = (column + 0.5) * field_w_ - across_y_ * dy / across_x_;
      if (x > x0 - 1 / across_x_ && x < x1 + 1 / across_x_) return 1.0;
    }
    return 0;
  }

  [[nodiscard]] std::vector<Edge> edges() const override {
    std::vector<Edge> result;
    const double gap_x = kMargin * field_w_ + kFieldEdgePx / 2;
    const double gap_y = kMargin * field_h_ + kFieldEdgePx / 2;
    for (int row = 0; row < kRows; ++row) {
      for (int column = 0; column < kColumns; ++column) {
        const double left = column * field_w_, top = row * field_h_;
        const TwoColours& c = kFields[field_index(column, row)];
        result.push_back({.x = left + field_w_ / 2,
                          .y = top + field_h_ / 2,
                          .angle_deg = angle_deg_,
                          .x0 = left + gap_x,
                          .y0 = top + gap_y,
                          .x1 = left + field_w_ - gap_x,
                          .y1 = top + field_h_ - gap_y,
                          .left = {c.left[0], c.left[1], c.left[2]},
                          .right = {c.right[0], c.right[1], c.right[2]}});
      }
    }
    return result;
  }

 private:
  static std::size_t field_index(int column, int row) {
    return static_cast<std::size_t>(row) * kColumns + static_cast<std::size_t>(column);
  }
  // Mean over a cell, from its value at three places.
  static float window(double local_px, double field_px, double side_px, float bend) {
    const double ends =
        std::min(local_px - kMargin * field_px, (1 - kMargin) * field_px - local_px);
    if (ends > kFieldEdgePx / 2.0 + side_px) return 1;
    if (ends < -kFieldEdgePx / 2.0 - side_px) return 0;
    const auto at = [&](double local) {
      const double inside = std::min(local - kMargin * field_px, (1 - kMargin) * field_px - local);
      return smooth_step(static_cast<float>(inside) / kFieldEdgePx);
    };
    const float here = at(local_px);
    if (here == 1 && at(local_px - side_px) == 1 && at(local_px + side_px) == 1) return 1;
    return here + (at(local_px - side_px) + at(local_px + side_px) - 2 * here) * bend;
  }
  double field_w_, field_h_, angle_deg_;
  double across_x_, across_y_;  // unit vector from left to right
};

}  // namespace

std::unique_ptr<Scene> make_zone_scene(double width_px, double height_px, double finest_cy_per_px) {
  return std::make_unique<ZoneScene>(width_px, height_px, finest_cy_per_px);
}

std::unique_ptr<Scene> make_star_scene(double width_px, double height_px, int spokes) {
  return std::make_unique<StarScene>(width_px, height_px, spokes);
}

std::unique_ptr<Scene> make_edges_scene(double width_px, double height_px, double angle_deg) {
  return std::make_unique<EdgesScene>(width_px, height_px, angle_deg);
}

}  // namespace reseau::sim
