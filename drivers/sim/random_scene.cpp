// A target of square cells that are clear or opaque by chance, chrome on glass, for calibration.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "drivers/sim/hash.h"
#include "drivers/sim/scene.h"

namespace reseau::sim {
namespace {

constexpr float kChrome = 0.02F;
constexpr int kCells = 1024;  // along either side of the target

struct Corner {
  double u, v;
};

// A convex figure of few corners.
struct Figure {
  std::array<Corner, 16> corner{};
  int n = 0;
  void add(double u, double v) { corner[static_cast<std::size_t>(n++)] = {u, v}; }
  [[nodiscard]] double area() const {
    double twice = 0;
    for (int i = 0; i < n; ++i) {
      const Corner& a = corner[static_cast<std::size_t>(i)];
      const Corner& b = corner[static_cast<std::size_t>((i + 1) % n)];
      twice += a.u * b.v - b.u * a.v;
    }
    return 0.5 * std::abs(twice);
  }
};

// The part on one side of the line where `height`, linear over the figure, is 0.
template <typename Height>
Figure cut(const Figure& from, const Height& height) {
  Figure out;
  for (int i = 0; i < from.n; ++i) {
    const Corner& a = from.corner[static_cast<std::size_t>(i)];
    const Corner& b = from.corner[static_cast<std::size_t>((i + 1) % from.n)];
    const double ha = height(a), hb = height(b);
    if (ha >= 0) out.add(a.u, a.v);
    if ((ha >= 0) != (hb >= 0)) {
      const double t = ha / (ha - hb);
      out.add(a.u + t * (b.u - a.u), a.v + t * (b.v - a.v));
    }
  }
  return out;
}

class RandomScene final : public Scene {
 public:
  RandomScene(double width_px, double height_px, std::uint64_t seed, double cell_px,
              double angle_deg)
      : cx_((width_px - 1) / 2),
        cy_((height_px - 1) / 2),
        cell_px_(cell_px),
        cos_(std::cos(angle_deg * std::numbers::pi / 180)),
        sin_(std::sin(angle_deg * std::numbers::pi / 180)) {
    clear_.reserve(static_cast<std::size_t>(kCells) * kCells);
    for (std::uint64_t row = 0; row < kCells; ++row) {
      for (std::uint64_t column = 0; column < kCells; ++column) {
        const std::uint64_t key = seed * 0x9e3779b97f4a7c15ULL + column * 0xd1b54a32d192ed03ULL +
                                  row * 0x8cb92ba72f3d8dd7ULL;
        clear_.push_back((mix64(mix64(key)) >> 63) != 0);
      }
    }
  }

  void row(double y, double x0, const RgbRow& out) const override { cells(y, x0, 1.0, out); }

  void cells(double y, double x0, double side_px, const RgbRow& out) const override {
    for (std::size_t i = 0; i < out.r.size(); ++i) {
      const double x = x0 + static_cast<double>(i) * side_px;
      const auto light = static_cast<float>(clear_share(x - cx_, y - cy_, side_px));
      out.r[i] = out.g[i] = out.b[i] = kChrome + light * (1 - kChrome);
    }
  }
  [[nodiscard]] bool has_fine_detail() const override { return true; }
  [[nodiscard]] double finest_cy_per_px(double /*y*/, double /*x0*/, double /*x1*/) const override {
    return 1.0;
  }

 private:
  [[nodiscard]] bool clear(int column, int row) const {
    return column >= 0 && row >= 0 && column < kCells && row < kCells &&
           clear_[static_cast<std::size_t>(row) * kCells + static_cast<std::size_t>(column)];
  }
  // Of a square of the scan about (dx, dy) from the middle: exact, in cells of the target.
  [[nodiscard]] double clear_share(double dx, double dy, double side_px) const {
    const double scale = 1 / cell_px_, half = side_px / 2;
    Figure square;
    double u_low = 1e9, u_high = -1e9, v_low = 1e9, v_high = -1e9;
    for (const auto& [sx, sy] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
      const double x = dx + sx * half, y = dy + sy * half;
      const double u = (cos_ * x - sin_ * y) * scale + 0.5 * kCells;
      const double v = (sin_ * x + cos_ * y) * scale + 0.5 * kCells;
      square.add(u, v);
      u_low = std::min(u_low, u);
      u_high = std::max(u_high, u);
      v_low = std::min(v_low, v);
      v_high = std::max(v_high, v);
    }
    const int c0 = static_cast<int>(std::floor(u_low)), c1 = static_cast<int>(std::floor(u_high));
    const int r0 = static_cast<int>(std::floor(v_low)), r1 = static_cast<int>(std::floor(v_high));
    if (c0 == c1 && r0 == r1) return clear(c0, r0) ? 1 : 0;
    double area = 0;
    for (int r = r0; r <= r1; ++r) {
      const Figure below = cut(square, [&](const Corner& c) { return c.v - r; });
      const Figure band = cut(below, [&](const Corner& c) { return r + 1 - c.v; });
      for (int c = c0; c <= c1; ++c) {
        if (!clear(c, r)) continue;
        const Figure right = cut(band, [&](const Corner& at) { return at.u - c; });
        area += cut(right, [&](const Corner& at) { return c + 1 - at.u; }).area();
      }
    }
    return area / square.area();
  }

  double cx_, cy_, cell_px_, cos_, sin_;
  std::vector<bool> clear_;
};

}  // namespace

std::unique_ptr<Scene> make_random_scene(double width_px, double height_px, std::uint64_t seed,
                                         double cell_px, double angle_deg) {
  return std::make_unique<RandomScene>(width_px, height_px, seed, cell_px, angle_deg);
}

}  // namespace reseau::sim
