// Test targets with detail finer than a pixel: every sample is the mean over its cell.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

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
    // Over a cell the phase is linear but for per_px * side^2, so that the mean of the cosine is
    // its value at the centre times the transfer function of the square.
    const double dy = y - cy_;
    const double across = sinc(per_px_ * dy * side_px);
    for (std::size_t i = 0; i < out.r.size(); ++i) {
      const double dx = x0 + static_cast<double>(i) * side_px - cx_;
      const double phase = std::numbers::pi * per_px_ * (dx * dx + dy * dy);
      const double wave = std::cos(phase) * across * sinc(per_px_ * dx * side_px);
      out.r[i] = out.g[i] = out.b[i] = static_cast<float>(kMean + kAmplitude * wave);
    }
  }

 private:
  double cx_, cy_, per_px_;  // centre; growth of the frequency [cycles/px/px]
};

class StarScene final : public FineScene {
 public:
  StarScene(double width_px, double height_px, int spokes)
      : cx_((width_px - 1) / 2), cy_((height_px - 1) / 2), spokes_(spokes) {}

  void cells(double y, double x0, double side_px, const RgbRow& out) const override {
    for (std::size_t i = 0; i < out.r.size(); ++i) {
      const double dx = x0 + static_cast<double>(i) * side_px - cx_;
      const double wave = mean_wave(dx, y - cy_, side_px, kDeepest);
      out.r[i] = out.g[i] = out.b[i] = static_cast<float>(kMean + kAmplitude * wave);
    }
  }

 private:
  static constexpr int kDeepest = 5;
  // Of the cosine over a square: value times transfer function where the spokes are straight over
  // the square, else the mean of its quarters.
  [[nodiscard]] double mean_wave(double dx, double dy, double side, int depth) const {
    constexpr double kLargestCurvature = 0.02;  // [radian] that the phase leaves a plane
    const double r2 = dx * dx + dy * dy;
    if (spokes_ * side * side / 8 <= kLargestCurvature * r2) {
      const double cy_per_px = spokes_ / (2 * std::numbers::pi * r2);  // times r
      return std::cos(spokes_ * std::atan2(dy, dx)) * sinc(cy_per_px * dy * side) *
             sinc(cy_per_px * dx * side);
    }
    if (depth == 0) return 0;  // many spokes within the square
    const double q = side / 4, half = side / 2;
    return 0.25 * (mean_wave(dx - q, dy - q, half, depth - 1) +
                   mean_wave(dx + q, dy - q, half, depth - 1) +
                   mean_wave(dx - q, dy + q, half, depth - 1) +
                   mean_wave(dx + q, dy + q, half, depth - 1));
  }
  double cx_, cy_;
  int spokes_;
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
    const float wy = window(y - field_row * field_h_, field_h_);
    const EdgeRamp ramp(across_x_ * side_px, across_y_ * side_px);
    const std::array<std::span<float>, 3> bands{out.r, out.g, out.b};
    for (std::size_t i = 0; i < out.r.size(); ++i) {
      const double x = x0 + static_cast<double>(i) * side_px;
      const int column = std::clamp(static_cast<int>(std::floor(x / field_w_)), 0, kColumns - 1);
      const double local_x = x - column * field_w_;
      const float w = wy * window(local_x, field_w_);
      const double distance = across_x_ * (local_x - field_w_ / 2) + across_y_ * (y - centre_y);
      const float right = ramp(static_cast<float>(distance));
      const TwoColours& colours = kFields[field_index(column, field_row)];
      for (std::size_t k = 0; k < 3; ++k) {
        const float value = colours.left[k] + right * (colours.right[k] - colours.left[k]);
        bands[k][i] = kGround + w * (value - kGround);
      }
    }
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
  static float window(double local_px, double field_px) {
    const double inside =
        std::min(local_px - kMargin * field_px, (1 - kMargin) * field_px - local_px);
    return smooth_step(static_cast<float>(inside) / kFieldEdgePx);
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
