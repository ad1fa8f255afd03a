// The full optics against closed forms. Figures are printed: they are the ones in OPTICS.md.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <numbers>

#include <gtest/gtest.h>

#include "drivers/sim/scan_renderer.h"
#include "tests/unit/sim/test_films.h"

namespace reseau::sim {
namespace {

constexpr double kPi = std::numbers::pi;

// Transfer of a round pupil, written down a second time: the integral along the shift by the
// midpoint rule after x = (1 - s) sin(t).
double lens(double s, double waves) {
  if (s >= 1) return 0;
  constexpr int kSteps = 400;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double t = kPi * ((i + 0.5) / kSteps - 0.5), x = (1 - s) * std::sin(t);
    const double h = 1 - (std::abs(x) + s) * (std::abs(x) + s);
    sum +=
        2 * std::sqrt(std::max(h, 0.0)) * std::cos(8 * kPi * waves * s * x) * (1 - s) * std::cos(t);
  }
  return sum / kSteps;
}

struct Case {
  const char* name;
  OpticsSpec optics;
  double defocus_um;
};

// Radial transfer along a direction, channel 0.
double transfer(const OpticsSpec& o, double f, double angle, double defocus_um) {
  const double core = std::exp(-2 * kPi * kPi * o.blur_px[0] * o.blur_px[0] * f * f);
  double sharp = core;
  if (o.f_number[0] > 0) {
    const double n = o.f_number[0], lambda = o.wavelength_um[0];
    sharp *= lens(f * lambda * n / o.pixel_um, defocus_um / (8 * n * n * lambda));
  }
  const double halo = std::exp(-2 * kPi * kPi * o.halo_px * o.halo_px * f * f);
  const double mixed = (1 - o.halo_fraction) * sharp + o.halo_fraction * halo;
  const double a_y = o.aperture_y_px > 0 ? o.aperture_y_px : o.aperture_px;
  return mixed * sinc_pi(o.aperture_px * f * std::cos(angle)) * sinc_pi(a_y * f * std::sin(angle));
}

// Edge spread function: 1/2 + integral of transfer x sin(2 pi f d) / (pi f).
class EdgeSpread {
 public:
  EdgeSpread(const OpticsSpec& o, double angle, double defocus_um, double farthest_px) {
    const double top = o.f_number[0] > 0 ? o.pixel_um / (o.wavelength_um[0] * o.f_number[0])
                                         : 1.2 / std::max(o.blur_px[0], 0.1);
    n_ = 2 * static_cast<int>(std::ceil(top * farthest_px * 24 + 400));
    step_ = top / n_;
    for (int i = 0; i <= n_; ++i) t_.push_back(transfer(o, i * step_, angle, defocus_um));
  }
  double operator()(double d) const {
    double sum = 0;
    for (int i = 0; i <= n_; ++i) {
      const double f = i * step_, w = i == 0 || i == n_ ? 1 : i % 2 == 1 ? 4 : 2;  // Simpson
      const double kernel = i == 0 ? 2 * d : std::sin(2 * kPi * f * d) / (kPi * f);
      sum += w * t_[static_cast<std::size_t>(i)] * kernel;
    }
    return 0.5 + sum * step_ / 3;
  }

 private:
  int n_;
  double step_;
  std::vector<double> t_;
};

OpticsSpec coolscan() {
  OpticsSpec o;
  o.blur_px = {0.23, 0, 0.21, 0.16};
  o.f_number = {8.7, 8.8, 9.1, 7.8};
  o.aperture_px = 2;
  return o;
}

struct Errors {
  double rms = 0, largest = 0;
};

Errors edge_errors(const Case& c, double angle_deg, int cells) {
  OpticsSpec optics = c.optics;
  optics.cells_per_px = cells;
  optics.focus_um = c.defocus_um;
  const ScanWindow window{.x_px = -12, .y_px = -3, .width_px = 24, .n_lines = 7};
  const auto t0 = std::chrono::steady_clock::now();
  std::vector<float> light(24 * 7 * kChannels);
  // A stage that errs by nothing visible keeps the full optics in use for every case.
  StageSpec stage;
  stage.wave_px = 1e-9;
  ScanRenderer(make_function_film(edge(angle_deg, 0.13)), optics, window,
               ScanGeometry(optics, stage, {}, 24, 1))
      .transmittance(0, 7, light);
  const auto t1 = std::chrono::steady_clock::now();
  const double angle = angle_deg * kPi / 180;
  const EdgeSpread exact(optics, angle, c.defocus_um, 20);
  Errors e;
  double sum = 0;
  for (int y = 0; y < 7; ++y) {
    for (int x = 0; x < 24; ++x) {
      const double d = (x - 12) * std::cos(angle) + (y - 3) * std::sin(angle) - 0.13;
      const double error = light[static_cast<std::size_t>(y * kChannels * 24 + x)] - exact(d);
      e.largest = std::max(e.largest, std::abs(error));
      sum += error * error;
    }
  }
  e.rms = std::sqrt(sum / (24 * 7));
  std::printf("%-28s %5.1f deg %2d cells: rms %.1e largest %.1e (%.0f ms)\n", c.name, angle_deg,
              cells, e.rms, e.largest, std::chrono::duration<double, std::milli>(t1 - t0).count());
  return e;
}

std::vector<Case> cases() {
  std::vector<Case> all;
  OpticsSpec o;
  all.push_back({"Gaussian 0.6", o, 0});
  o = coolscan();
  all.push_back({"f/8.7, aperture 2", o, 0});
  all.push_back({"f/8.7, aperture 2, 60 um", o, 60});
  o.halo_fraction = 0.1;
  all.push_back({"with a halo of 10 %", o, 20});
  o = coolscan();
  o.aperture_px = 1;
  o.f_number.fill(4);
  o.blur_px.fill(0);
  all.push_back({"f/4, aperture 1", o, 0});
  o.f_number.fill(22);
  all.push_back({"f/22, aperture 1", o, 0});
  return all;
}

TEST(OpticsRefinement, SlantedEdgeIsItsIntegral) {
  for (const Case& c : cases()) {
    for (const double angle : {0.0, 4.7, 23.0, 45.0, 90.0}) {
      const Errors e = edge_errors(c, angle, 0);
      EXPECT_LT(e.rms, 1e-4) << c.name;
    }
  }
}

}  // namespace
}  // namespace reseau::sim
