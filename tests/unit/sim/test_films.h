// Films whose image under any optics has a closed form.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "drivers/sim/film.h"

namespace reseau::sim {

inline constexpr int kFarPx = 1 << 20;

// Cells by a function of their centre's place and side.
template <typename CellMean>
class FunctionFilm final : public Film {
 public:
  FunctionFilm(CellMean mean, double height_um, Edges edges)
      : mean_(mean), height_um_(height_um), edges_(edges) {}
  [[nodiscard]] Edges edges() const override { return edges_; }
  [[nodiscard]] Extent extent() const override { return {-kFarPx, kFarPx}; }
  void cells(double y, int first_px, int n_px, int per_px, CellRow& out) const override {
    out.resize(first_px, n_px, per_px);
    for (int s = 0; s < per_px; ++s) {
      for (int i = 0; i < n_px; ++i) {
        const double x = first_px + i + (s + 0.5) / per_px - 0.5;
        const auto value = static_cast<float>(mean_(x, y, 1.0 / per_px));
        for (int c = 0; c < kChannels; ++c) out.phase(c, s)[i] = value;
      }
    }
  }
  [[nodiscard]] double height_um(double /*x*/, double /*y*/) const override { return height_um_; }

 private:
  CellMean mean_;
  double height_um_;
  Edges edges_;
};

template <typename CellMean>
std::shared_ptr<const Film> make_function_film(CellMean mean, double height_um = 0,
                                               Film::Edges edges = {}) {
  return std::make_shared<FunctionFilm<CellMean>>(mean, height_um, edges);
}

// Clear where x cos(angle) + y sin(angle) > offset. The mean over a cell is the integral of a
// trapezoid: the cell's two sides projected on the normal.
inline auto edge(double angle_deg, double offset_px) {
  const double nx = std::cos(angle_deg * std::numbers::pi / 180);
  const double ny = std::sin(angle_deg * std::numbers::pi / 180);
  return [=](double x, double y, double side) {
    const double d = x * nx + y * ny - offset_px;
    const double a = std::max(std::abs(nx), std::abs(ny)) * side;
    const double b = std::max(std::min(std::abs(nx), std::abs(ny)) * side, 1e-5);
    const auto ramp = [](double t) { return t > 0 ? t * t / 2 : 0.0; };
    const double p = (a + b) / 2, q = (a - b) / 2;
    return (ramp(d + p) - ramp(d + q) - ramp(d - q) + ramp(d - p)) / (a * b);
  };
}

inline double sinc_pi(double x) {
  return std::abs(x) < 1e-12 ? 1.0 : std::sin(std::numbers::pi * x) / (std::numbers::pi * x);
}

// 0.5 + 0.5 cos(2 pi (f_x x + f_y y)).
inline auto sinusoid(double f_x, double f_y) {
  return [=](double x, double y, double side) {
    return 0.5 + 0.5 * sinc_pi(f_x * side) * sinc_pi(f_y * side) *
                     std::cos(2 * std::numbers::pi * (f_x * x + f_y * y));
  };
}

// Transfer of a round pupil, written down a second time: the integral along the shift by the
// midpoint rule after x = (1 - s) sin(t).
inline double lens(double s, double waves) {
  if (s >= 1) return 0;
  constexpr int kSteps = 400;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double t = std::numbers::pi * ((i + 0.5) / kSteps - 0.5), x = (1 - s) * std::sin(t);
    const double h = 1 - (std::abs(x) + s) * (std::abs(x) + s);
    sum += 2 * std::sqrt(std::max(h, 0.0)) * std::cos(8 * std::numbers::pi * waves * s * x) *
           (1 - s) * std::cos(t);
  }
  return sum / kSteps;
}

}  // namespace reseau::sim
