// What is laid into a scanner to measure it: blades with slanted edges, an open frame.
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "drivers/sim/edge_ramp.h"
#include "drivers/sim/scene.h"

namespace reseau::sim {
namespace {

constexpr float kBladeLight = 0.02F;  // chrome on glass, and the stray light that any scanner has
constexpr double kFieldPx = 900;      // one blade for about so much of the frame

// Square blades, turned by the slant: edges of both directions all over the frame.
class RazorScene final : public Scene {
 public:
  RazorScene(double width_px, double height_px, double angle_deg)
      : columns_(std::max(1, static_cast<int>(std::lround(width_px / kFieldPx)))),
        rows_(std::max(1, static_cast<int>(std::lround(height_px / kFieldPx)))),
        field_w_(width_px / columns_),
        field_h_(height_px / rows_),
        half_(std::min(field_w_, field_h_) / 4),
        angle_deg_(angle_deg),
        across_x_(std::cos(angle_deg * std::numbers::pi / 180)),
        across_y_(-std::sin(angle_deg * std::numbers::pi / 180)) {}

  void row(double y, double x0, const RgbRow& out) const override { cells(y, x0, 1.0, out); }

  void cells(double y, double x0, double side_px, const RgbRow& out) const override {
    // Coordinates along the blade's own axes: a = across . p, b = along . p, along = (-across_y,
    // across_x).
    const EdgeRamp of_a(across_x_ * side_px, across_y_ * side_px);
    const EdgeRamp of_b(-across_y_ * side_px, across_x_ * side_px);
    const int field_row = std::clamp(static_cast<int>(std::floor(y / field_h_)), 0, rows_ - 1);
    const double dy = y - (field_row + 0.5) * field_h_;
    for (std::size_t i = 0; i < out.r.size(); ++i) {
      const double x = x0 + static_cast<double>(i) * side_px;
      const int column = std::clamp(static_cast<int>(std::floor(x / field_w_)), 0, columns_ - 1);
      const double dx = x - (column + 0.5) * field_w_;
      const double a = across_x_ * dx + across_y_ * dy, b = across_x_ * dy - across_y_ * dx;
      const float covered = of_a(static_cast<float>(half_ - std::abs(a))) *
                            of_b(static_cast<float>(half_ - std::abs(b)));
      out.r[i] = out.g[i] = out.b[i] = 1 + covered * (kBladeLight - 1);
    }
  }
  [[nodiscard]] bool has_fine_detail() const override { return true; }
  [[nodiscard]] double finest_cy_per_px(double /*y*/, double /*x0*/, double /*x1*/) const override {
    return 1.0;
  }

  [[nodiscard]] std::vector<Edge> edges() const override {
    std::vector<Edge> result;
    constexpr double kAside = 0.5;  // of half a blade, that is free of other edges
    for (int row = 0; row < rows_; ++row) {
      for (int column = 0; column < columns_; ++column) {
        const double cx = (column + 0.5) * field_w_, cy = (row + 0.5) * field_h_;
        for (const double side : {-1.0, 1.0}) {
          result.push_back(edge_at(cx + side * half_ * across_x_, cy + side * half_ * across_y_,
                                   angle_deg_, side > 0, kAside));
          // Across the other axis, whose normal (-across_y, across_x) points away from +x for a
          // positive slant.
          const bool positive = angle_deg_ >= 0;
          const double turned = positive ? angle_deg_ - 90 : angle_deg_ + 90;
          const bool clear_right = positive == (side > 0);
          result.push_back(edge_at(cx - side * half_ * across_y_, cy + side * half_ * across_x_,
                                   turned, clear_right, kAside));
        }
      }
    }
    return result;
  }

 private:
  [[nodiscard]] Edge edge_at(double x, double y, double angle_deg, bool clear_right,
                             double aside) const {
    constexpr std::array<double, 3> kClear{1, 1, 1};
    constexpr auto kLight = static_cast<double>(kBladeLight);
    constexpr std::array<double, 3> kBlade{kLight, kLight, kLight};
    const double reach = aside * half_;
    return {.x = x,
            .y = y,
            .angle_deg = angle_deg,
            .x0 = x - reach,
            .y0 = y - reach,
            .x1 = x + reach,
            .y1 = y + reach,
            .left = clear_right ? kBlade : kClear,
            .right = clear_right ? kClear : kBlade};
  }
  int columns_, rows_;
  double field_w_, field_h_;
  double half_;  // side of a blade, halved
  double angle_deg_, across_x_, across_y_;
};

class ClearScene final : public Scene {
 public:
  void row(double /*y*/, double /*x0*/, const RgbRow& out) const override {
    for (const std::span<float> band : {out.r, out.g, out.b}) std::ranges::fill(band, 1.0F);
  }
};

}  // namespace

std::unique_ptr<Scene> make_razor_scene(double width_px, double height_px, double angle_deg) {
  return std::make_unique<RazorScene>(width_px, height_px, angle_deg);
}

std::unique_ptr<Scene> make_clear_scene() { return std::make_unique<ClearScene>(); }

}  // namespace reseau::sim
