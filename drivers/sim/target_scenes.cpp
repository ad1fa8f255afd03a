// Test targets with detail finer than a pixel: every sample is the mean over its cell.
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <vector>

#include "drivers/sim/edge_ramp.h"
#include "drivers/sim/scene.h"
#include "drivers/sim/smooth_step.h"

namespace reseau::sim {
namespace {

constexpr double kMean = 0.5, kAmplitude = 0.45;

double sinc(double x) {
  return std::abs(x) < 1e-9 ? 1.0 : std::sin(std::numbers::pi * x) / (std::numbers::pi * x);
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
    // The phase is a sum of one part in x and one in y: so is the exponent's mean a product.
    struct Across {
      std::array<double, 4> made_for{};
      std::vector<std::complex<double>> wave;
    };
    thread_local std::array<Across, 8> kept;  // rows are asked for at a few places in turn
    thread_local std::size_t oldest = 0;
    const std::array<double, 4> wanted{per_px_, x0 - cx_, side_px,
                                       static_cast<double>(out.r.size())};
    auto found = std::ranges::find(kept, wanted, &Across::made_for);
    const bool known = found != kept.end();
    if (!known) found = kept.begin() + static_cast<std::ptrdiff_t>(oldest++ % kept.size());
    std::vector<std::complex<double>>& across = found->wave;
    if (!known) {
      found->made_for = wanted;
      across.resize(out.r.size());
      for (std::size_t i = 0; i < across.size(); ++i) {
        across[i] = mean_of_chirp(x0 + static_cast<double>(i) * side_px - cx_, side_px);
      }
    }
    const std::complex<double> down = mean_of_chirp(y - cy_, side_px);
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
    for (std::size_t i = 0; i < out.r.size(); ++i) {
      const double dx = x0 + static_cast<double>(i) * side_px - cx_;
      const double wave = mean_wave(dx, y - cy_, side_px, kDeepest);
      out.r[i] = out.g[i] = out.b[i] = static_cast<float>(kMean + kAmplitude * wave);
    }
  }
  [[nodiscard]] double finest_cy_per_px(double y, double x0, double x1) const override {
    const double x = std::max({x0 - cx_, cx_ - x1, 0.0});
    return spokes_ / (2 * std::numbers::pi * std::max(std::hypot(x, y - cy_), 0.8 * disc_px_));
  }

 private:
  static constexpr int kDeepest = 6;
  static constexpr double kFinest = 1.5;  // cycles per px, where the spokes end at an even disc
  // Of the cosine over a square: value times transfer function where the spokes are straight over
  // the square, else the mean of its quarters.
  [[nodiscard]] double mean_wave(double dx, double dy, double side, int depth) const {
    constexpr double kLargestCurvature = 0.002;  // [radian] that the phase leaves a plane
    const double r2 = dx * dx + dy * dy;
    const double r = std::sqrt(r2), fade_px = 0.4 * disc_px_;
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
    const int field_row = std::clamp(static_cast<int>(std::floor(y / field_h_)), 0, kRows - 1);
    const double centre_y = (field_row + 0.5) * field_h_;
    const float wy = window(y - field_row * field_h_, field_h_, side_px);
    const EdgeRamp ramp(across_x_ * side_px, across_y_ * side_px);
    const std::array<std::span<float>, 3> bands{out.r, out.g, out.b};
    for (std::size_t i = 0; i < out.r.size(); ++i) {
      const double x = x0 + static_cast<double>(i) * side_px;
      const int column = std::clamp(static_cast<int>(std::floor(x / field_w_)), 0, kColumns - 1);
      const double local_x = x - column * field_w_;
      const float w = wy * window(local_x, field_w_, side_px);
      const double distance = across_x_ * (local_x - field_w_ / 2) + across_y_ * (y - centre_y);
      const float right = ramp(static_cast<float>(distance));
      const TwoColours& colours = kFields[field_index(column, field_row)];
      for (std::size_t k = 0; k < 3; ++k) {
        const float value = colours.left[k] + right * (colours.right[k] - colours.left[k]);
        bands[k][i] = kGround + w * (value - kGround);
      }
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
  static float window(double local_px, double field_px, double side_px) {
    const auto at = [&](double local) {
      const double inside = std::min(local - kMargin * field_px, (1 - kMargin) * field_px - local);
      return smooth_step(static_cast<float>(inside) / kFieldEdgePx);
    };
    const float here = at(local_px);
    if (here == 1 && at(local_px - side_px) == 1 && at(local_px + side_px) == 1) return 1;
    return here + (at(local_px - side_px) + at(local_px + side_px) - 2 * here) / 24;
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
