#include <algorithm>
#include <cmath>
#include <cstddef>

#include "drivers/sim/scene.h"
#include "drivers/sim/smooth_step.h"

namespace reseau::sim {
namespace {

constexpr int kColumns = 6;
constexpr int kRows = 4;
constexpr double kMargin = 0.06;  // of a cell, on every side of its patch
constexpr float kEdgePx = 3.0F;   // width of the transition
constexpr float kGround = 0.30F;

// Linear exposures. Skin, foliage, sky and flowers first, then saturated and bright colours; the
// last row is neutral.
constexpr std::array<std::array<float, 3>, 24> kPatches{{
    {0.17F, 0.08F, 0.06F}, {0.54F, 0.31F, 0.22F}, {0.12F, 0.20F, 0.34F}, {0.10F, 0.15F, 0.05F},
    {0.24F, 0.22F, 0.44F}, {0.13F, 0.51F, 0.40F}, {0.68F, 0.21F, 0.03F}, {0.07F, 0.10F, 0.38F},
    {0.53F, 0.10F, 0.12F}, {0.11F, 0.05F, 0.14F}, {0.34F, 0.50F, 0.05F}, {0.75F, 0.37F, 0.03F},
    {0.03F, 0.05F, 0.29F}, {0.06F, 0.30F, 0.06F}, {0.43F, 0.03F, 0.04F}, {0.81F, 0.57F, 0.02F},
    {0.50F, 0.09F, 0.30F}, {0.02F, 0.24F, 0.38F}, {0.95F, 0.95F, 0.95F}, {0.59F, 0.59F, 0.59F},
    {0.36F, 0.36F, 0.36F}, {0.19F, 0.19F, 0.19F}, {0.09F, 0.09F, 0.09F}, {0.03F, 0.03F, 0.03F},
}};

class ChartScene final : public Scene {
 public:
  ChartScene(double width_px, double height_px)
      : cell_w_(width_px / kColumns), cell_h_(height_px / kRows) {}

  void row(double y, double x0, const RgbRow& out) const override {
    const int cell_row = std::clamp(static_cast<int>(std::floor(y / cell_h_)), 0, kRows - 1);
    const float wy = window(y - cell_row * cell_h_, cell_h_);
    std::size_t i = 0;
    while (i < out.r.size()) {
      const double x = x0 + static_cast<double>(i);
      const int column = std::clamp(static_cast<int>(std::floor(x / cell_w_)), 0, kColumns - 1);
      std::size_t end = out.r.size();
      if (column + 1 < kColumns) {
        const double last = std::ceil((column + 1) * cell_w_ - x0);
        end = std::clamp(static_cast<std::size_t>(std::max(0.0, last)), i + 1, end);
      }
      const auto& rgb = kPatches[static_cast<std::size_t>(cell_row) * kColumns +
                                 static_cast<std::size_t>(column)];
      for (; i < end; ++i) {
        const double local = x0 + static_cast<double>(i) - column * cell_w_;
        const float w = wy * window(local, cell_w_);
        out.r[i] = kGround + w * (rgb[0] - kGround);
        out.g[i] = kGround + w * (rgb[1] - kGround);
        out.b[i] = kGround + w * (rgb[2] - kGround);
      }
    }
  }

  [[nodiscard]] std::vector<Patch> patches() const override {
    std::vector<Patch> result;
    const double half_edge = kEdgePx / 2;
    for (int k = 0; k < kColumns * kRows; ++k) {
      const int column = k % kColumns;
      const int row = k / kColumns;
      const double left = column * cell_w_;
      const double top = row * cell_h_;
      const auto& rgb = kPatches[static_cast<std::size_t>(k)];
      result.push_back({.x0 = left + kMargin * cell_w_ + half_edge,
                        .y0 = top + kMargin * cell_h_ + half_edge,
                        .x1 = left + (1 - kMargin) * cell_w_ - half_edge,
                        .y1 = top + (1 - kMargin) * cell_h_ - half_edge,
                        .rgb = {rgb[0], rgb[1], rgb[2]}});
    }
    return result;
  }

 private:
  // 1 inside the patch, 0 in the gap between patches.
  static float window(double local_px, double cell_px) {
    const double inside =
        std::min(local_px - kMargin * cell_px, (1 - kMargin) * cell_px - local_px);
    return smooth_step(static_cast<float>(inside) / kEdgePx);
  }
  double cell_w_, cell_h_;
};

}  // namespace

std::unique_ptr<Scene> make_chart_scene(double width_px, double height_px) {
  return std::make_unique<ChartScene>(width_px, height_px);
}

}  // namespace reseau::sim
