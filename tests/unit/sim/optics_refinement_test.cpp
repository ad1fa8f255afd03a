// The full optics against closed forms. Figures are printed: they are the ones in OPTICS.md.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "drivers/sim/optical_transfer.h"
#include "drivers/sim/scan_renderer.h"
#include "tests/unit/sim/test_films.h"

namespace reseau::sim {
namespace {

constexpr double kPi = std::numbers::pi;

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
  // The film says how its edge lies, from black to white, as films with elements do.
  const Film::Edges edges{.off_axes_deg = std::min(angle_deg, 90 - angle_deg), .contrast = 1};
  ScanRenderer(make_function_film(edge(angle_deg, 0.13), 0, edges), optics, window,
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
  double worst_rms = 0, worst = 0;
  for (const Case& c : cases()) {
    for (const double angle : {0.0, 4.7, 23.0, 45.0, 90.0}) {
      const Errors e = edge_errors(c, angle, 0);
      EXPECT_LT(e.rms, 6e-5) << c.name << " at " << angle;
      EXPECT_LT(e.largest, 1e-4) << c.name << " at " << angle;
      worst_rms = std::max(worst_rms, e.rms);
      worst = std::max(worst, e.largest);
    }
  }
  std::printf("all edges: rms up to %.1e, largest %.1e of bare light\n", worst_rms, worst);
}

// Far from the edge only diffraction's tails and the halo are left: 0.0645 / (cutoff x distance).
TEST(OpticsRefinement, TailsOfAnEdgeReachAsFarAsTheyShould) {
  OpticsSpec optics = coolscan();
  const auto film = make_function_film(edge(0, 0.0));
  const EdgeSpread exact(optics, 0, 0, 400);
  double worst = 0;
  for (const int x : {-20, -40, -80, -160, -320}) {
    std::vector<float> light(4UL * kChannels);
    ScanRenderer(film, optics, {.x_px = x, .width_px = 4, .n_lines = 1}).transmittance(0, 1, light);
    const double expected = exact(x);
    worst = std::max(worst, std::abs(light[0] - expected));
    EXPECT_NEAR(light[0], expected, 1e-4) << x;
    if (x > -100) {
      EXPECT_NEAR(light[0] / expected, 1, 0.05) << x;
    }
  }
  std::printf("tails from 20 to 320 px: largest error %.1e\n", worst);
}

TEST(OpticsRefinement, SinusoidIsScaledByTheTransferFunction) {
  OpticsSpec optics = coolscan();
  optics.aperture_y_px = 1.5;
  optics.halo_fraction = 0.05;
  optics.focus_um = 45;
  double worst = 0;
  for (const auto& [f_x, f_y] : {std::pair{0.004, 0.003},
                                 {0.03, 0.0},
                                 {0.0, 0.09},
                                 {0.11, 0.07},
                                 {0.2, -0.1},
                                 {0.31, 0.0},
                                 {0.0, 0.42},
                                 {0.3, 0.3},
                                 {0.7, 0.4}}) {
    const ScanWindow window{.x_px = 5, .y_px = 9, .width_px = 16, .n_lines = 4};
    std::vector<float> light(16 * 4 * kChannels);
    ScanRenderer(make_function_film(sinusoid(f_x, f_y)), optics, window).transmittance(0, 4, light);
    const double t = transfer(optics, std::hypot(f_x, f_y), std::atan2(f_y, f_x), 45);
    for (int y = 0; y < 4; ++y) {
      for (int x = 0; x < 16; ++x) {
        const double phase = 2 * kPi * (f_x * (x + 5) + f_y * (y + 9));
        const double error = light[static_cast<std::size_t>(y * kChannels * 16 + x)] - 0.5 -
                             0.5 * t * std::cos(phase);
        worst = std::max(worst, std::abs(error));
      }
    }
  }
  std::printf("sinusoids from 0.005 to 0.8 cycles/px: largest error %.1e\n", worst);
  EXPECT_LT(worst, 1e-4);
}

// Astigmatism: the transfer by brute force over the pupil.
TEST(OpticsRefinement, AstigmaticTransferIsThePupilsOwnCorrelation) {
  const auto brute = [](double s_x, double s_y, double w_x, double w_y) {
    constexpr int kN = 1200;
    double sum = 0;
    for (int j = 0; j < kN; ++j) {
      for (int i = 0; i < kN; ++i) {
        const double x = 2 * (i + 0.5) / kN - 1, y = 2 * (j + 0.5) / kN - 1;
        const double ax = x + s_x, ay = y + s_y, bx = x - s_x, by = y - s_y;
        if (ax * ax + ay * ay > 1 || bx * bx + by * by > 1) continue;
        const double a = w_x * ax * ax + w_y * ay * ay, b = w_x * bx * bx + w_y * by * by;
        sum += std::cos(2 * kPi * (a - b));
      }
    }
    return sum * 4 / (kN * kN) / kPi;
  };
  double worst = 0;
  for (const auto& [s_x, s_y] : {std::pair{0.2, 0.1}, {0.0, 0.5}, {0.45, -0.3}, {0.6, 0.6}}) {
    for (const auto& [w_x, w_y] : {std::pair{0.0, 0.0}, {0.3, 0.3}, {0.5, -0.2}, {1.1, 0.0}}) {
      worst =
          std::max(worst, std::abs(lens_transfer(s_x, s_y, w_x, w_y) - brute(s_x, s_y, w_x, w_y)));
    }
  }
  std::printf("lens transfer against the pupil on a grid: largest difference %.1e\n", worst);
  EXPECT_LT(worst, 1e-4);
  EXPECT_NEAR(lens_transfer(0.3, 0, 0.4, 0.4), lens(0.3, 0.4), 1e-6);
}

// A small clear square in the dark: its light, place and width.
TEST(OpticsRefinement, PointKeepsItsLightItsPlaceAndTheWidthsAddUp) {
  constexpr double kSide = 0.5, kX = 20.37, kY = 17.81, kSigma = 0.8, kAperture = 1.4;
  const auto overlap = [](double a, double b, double c, double d) {
    return std::max(0.0, std::min(b, d) - std::max(a, c));
  };
  const auto film = make_function_film([=](double x, double y, double side) {
    return overlap(x - side / 2, x + side / 2, kX - kSide / 2, kX + kSide / 2) *
           overlap(y - side / 2, y + side / 2, kY - kSide / 2, kY + kSide / 2) / (side * side);
  });
  OpticsSpec optics;
  optics.blur_px.fill(kSigma);
  optics.aperture_px = kAperture;
  optics.aperture_y_px = 1.0;
  const ScanWindow window{.width_px = 40, .n_lines = 36};
  std::vector<float> light(40 * 36 * kChannels);
  ScanRenderer(film, optics, window).transmittance(0, 36, light);
  double sum = 0, x1 = 0, y1 = 0, x2 = 0, y2 = 0;
  for (int y = 0; y < 36; ++y) {
    for (int x = 0; x < 40; ++x) {
      const double v = light[static_cast<std::size_t>(y * kChannels * 40 + x)];
      sum += v, x1 += v * x, y1 += v * y;
      x2 += v * (x - kX) * (x - kX), y2 += v * (y - kY) * (y - kY);
    }
  }
  std::printf("area %.6f of %.6f, centroid off by %.1e, %.1e px, variances %.5f %.5f\n", sum,
              kSide * kSide, x1 / sum - kX, y1 / sum - kY, x2 / sum, y2 / sum);
  EXPECT_NEAR(sum, kSide * kSide, 2e-5);
  EXPECT_NEAR(x1 / sum, kX, 2e-3);
  EXPECT_NEAR(y1 / sum, kY, 2e-3);
  const double square = kSide * kSide / 12;
  EXPECT_NEAR(x2 / sum, kSigma * kSigma + kAperture * kAperture / 12 + square, 5e-3);
  EXPECT_NEAR(y2 / sum, kSigma * kSigma + 1.0 / 12 + square, 5e-3);
}

TEST(OpticsRefinement, SampledSpreadFunctionHasItsLightCentreAndWidth) {
  OpticsSpec optics;
  optics.blur_px.fill(0.7);
  optics.aperture_px = 2;
  optics.aperture_y_px = 1;
  const PsfGrid g = sample_psf(optics, 1, 0, 8, 6);
  ASSERT_EQ(g.side, 97);
  double sum = 0, x2 = 0, y2 = 0, x1 = 0;
  for (int j = 0; j < g.side; ++j) {
    for (int i = 0; i < g.side; ++i) {
      const double v = g.values[static_cast<std::size_t>(j * g.side + i)] / 64;
      const double x = (i - 48) / 8.0, y = (j - 48) / 8.0;
      sum += v, x1 += v * x, x2 += v * x * x, y2 += v * y * y;
    }
  }
  EXPECT_NEAR(sum, 1, 1e-6);
  EXPECT_NEAR(x1, 0, 1e-9);
  EXPECT_NEAR(x2, 0.49 + 4.0 / 12, 1e-4);
  EXPECT_NEAR(y2, 0.49 + 1.0 / 12, 1e-4);
  // A lens: what is missing beyond 10 px is the tail's 2 / (pi^2 cutoff r), and infrared is softer.
  const OpticsSpec lens = coolscan();
  std::array<double, 2> peak{}, inside{};
  for (const int k : {0, 1}) {
    const PsfGrid p = sample_psf(lens, k == 0 ? 1 : 3, 0, 4, 10);
    peak[static_cast<std::size_t>(k)] = p.values[p.values.size() / 2];
    for (int j = 0; j < p.side; ++j) {
      for (int i = 0; i < p.side; ++i) {
        if (std::hypot(i - 40, j - 40) <= 40) {
          inside[static_cast<std::size_t>(k)] +=
              p.values[static_cast<std::size_t>(j * p.side + i)] / 16;
        }
      }
    }
  }
  EXPECT_GT(peak[0], 1.04 * peak[1]);
  const double cutoff = lens.pixel_um / (lens.wavelength_um[1] * lens.f_number[1]);
  EXPECT_NEAR(1 - inside[0], 2 / (kPi * kPi * cutoff * 10), 2e-3);
  EXPECT_THROW((void)sample_psf(lens, 4, 0, 4, 10), InputError);
  EXPECT_THROW((void)sample_psf(lens, 0, 0, 0, 10), InputError);
  EXPECT_THROW((void)sample_psf(lens, 0, 0, 100, 100), InputError);
}

TEST(OpticsRefinement, EstimateTellsTheTrueErrorOfARendering) {
  for (const int cells : {4, 6, 8}) {
    OpticsSpec optics;
    optics.cells_per_px = cells;
    optics.shift_x_px = {1e-9, 0, 0, 0};
    const ScanWindow window{.x_px = -8, .y_px = -2, .width_px = 16, .n_lines = 4};
    const auto film = make_function_film(edge(4.7, 0.13));
    const RenderError estimate = estimate_error(film, optics, window, ScanGeometry(), 1);
    EXPECT_EQ(estimate.cells_per_px, cells);
    std::vector<float> light(16 * 4 * kChannels);
    ScanRenderer(film, optics, window).transmittance(0, 4, light);
    const double angle = 4.7 * kPi / 180;
    const EdgeSpread exact(optics, angle, 0, 20);
    double sum = 0;
    for (int y = 0; y < 4; ++y) {
      for (int x = 0; x < 16; ++x) {
        const double d = (x - 8) * std::cos(angle) + (y - 2) * std::sin(angle) - 0.13;
        sum += std::pow(light[static_cast<std::size_t>(y * kChannels * 16 + x)] - exact(d), 2);
      }
    }
    const double truth = std::sqrt(sum / 64);
    std::printf("%d cells: estimated rms %.1e, true %.1e\n", cells, estimate.rms, truth);
    EXPECT_GT(estimate.rms, 0.3 * truth - 3e-6);
    EXPECT_LT(estimate.rms, 3 * truth + 3e-6);
  }
}

}  // namespace
}  // namespace reseau::sim
