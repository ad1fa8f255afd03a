// The rendered film against a closed form: the Fourier series of the réseau times the transfer
// function of blur and pixel aperture.
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include <gtest/gtest.h>

#include "drivers/sim/simulate.h"

namespace reseau::sim {
namespace {

constexpr double kPi = std::numbers::pi;

// Fourier coefficient k of a bar of width w (in periods) around 0.
double bar(int k, double w) { return k == 0 ? w : std::sin(kPi * k * w) / (kPi * k); }
double sinc(double x) { return x == 0 ? 1 : std::sin(kPi * x) / (kPi * x); }

class AnalyticScreen {
 public:
  AnalyticScreen(const SimSpec& spec, const FilmTruth& truth, std::array<double, 3> silver)
      : spec_(spec), truth_(truth), silver_(silver) {}

  double operator()(double x, double y, std::size_t channel) const {
    const ElementResponse p = element_response(spec_.film.dyes.fade);
    const ScreenGradient g = truth_.mean_gradient();
    const ScreenPoint s = truth_.screen_from_scan(x, y);
    std::array<double, 3> level{};
    for (std::size_t k = 0; k < 3; ++k) {
      level[k] = silver_[k] * (channel == kInfrared ? 1.0 : p[k][channel]);
    }
    const double sigma = spec_.optics.blur_px[channel], a = spec_.optics.aperture_px;
    std::complex<double> sum = 0;
    constexpr int kOrders = 10;
    for (int m = -kOrders; m <= kOrders; ++m) {
      const double green = bar(m, spec_.film.screen.green_fraction);
      for (int n = -kOrders; n <= kOrders; ++n) {
        const double red = bar(n, spec_.film.screen.red_fraction) * (n % 2 == 0 ? 1 : -1);
        const double between = (n == 0 ? 1.0 : 0.0) - red;
        const double c = level[0] * (m == 0 ? red : 0.0) + level[1] * between * green +
                         level[2] * between * ((m == 0 ? 1.0 : 0.0) - green);
        const double fx = m * g.u_x + n * g.v_x, fy = m * g.u_y + n * g.v_y;
        const double otf = std::exp(-2 * kPi * kPi * sigma * sigma * (fx * fx + fy * fy)) *
                           sinc(a * fx) * sinc(a * fy);
        sum += c * otf * std::polar(1.0, 2 * kPi * (m * s.u + n * s.v));
      }
    }
    return sum.real();
  }

 private:
  SimSpec spec_;
  const FilmTruth& truth_;
  std::array<double, 3> silver_;
};

struct Errors {
  double largest = 0, rms = 0;
};

// Inside one patch of a chart so large that nothing else is near.
Errors errors_of(const SimSpec& spec) {
  const ScanWindow window{.x_px = 4000, .y_px = 6000, .width_px = 32, .n_lines = 20};
  const FilmTruth truth(spec.film, window);
  const ScanRenderer renderer(make_film(spec.film), spec.optics, window);
  std::vector<float> light(static_cast<std::size_t>(32 * 20 * kChannels));
  renderer.transmittance(0, 20, light);
  const AnalyticScreen exact(spec, truth, truth.process_rgb(16, 10));
  Errors e;
  for (int y = 0; y < 20; ++y) {
    for (std::size_t c = 0; c < kChannels; ++c) {
      for (int x = 0; x < 32; ++x) {
        const auto at =
            (static_cast<std::size_t>(y) * kChannels + c) * 32 + static_cast<std::size_t>(x);
        const double error = std::abs(light[at] - exact(x, y, c));
        e.largest = std::max(e.largest, error);
        e.rms += error * error;
      }
    }
  }
  e.rms = std::sqrt(e.rms / static_cast<double>(light.size()));
  return e;
}

SimSpec large_chart(const std::string& settings) {
  return parse_sim_spec("ls5000?width_px=20000&height_px=20000&" + settings);
}

TEST(FilmOptics, RenderingIsTheFourierSeriesTimesTheTransferFunction) {
  // Bare light is 1; a step of a 16-bit scan is 1.5e-5. Where edges run along the rows of cells
  // their sampling errors do not average out, so a finer grid is asked for.
  for (const char* settings :
       {"angle=23", "angle=0&axes=90&cells=8", "angle=45&axes=89", "angle=-67&axes=88.9&mirrored=1",
        "angle=23&blur_px=0.4&ir_blur_px=1.5", "angle=23&aperture_px=2&blur_px=0.4",
        "angle=23&period_um=60&fade=0.5"}) {
    const Errors e = errors_of(large_chart(settings));
    EXPECT_LT(e.largest, 5e-4) << settings;
    EXPECT_LT(e.rms, 6e-5) << settings;
  }
  const Errors along_the_rows = errors_of(large_chart("angle=0&axes=90"));
  EXPECT_LT(along_the_rows.rms, 2.5e-4);
}

TEST(FilmOptics, FinerCellsConvergeToTheClosedForm) {
  double previous = 1;
  for (const char* cells : {"2", "4", "8"}) {
    const Errors e = errors_of(large_chart(std::string("angle=23&cells=") + cells));
    EXPECT_LT(e.rms, previous / 2.5) << cells;
    previous = e.rms;
  }
  EXPECT_LT(previous, 1e-5);
}

// The smooth bend changes local frequencies, so there is no closed form; the finest grid stands in.
TEST(FilmOptics, BendAndWobbleAreRenderedAsExactlyAsTheFlatFilm) {
  for (const char* settings :
       {"bend_px=5", "wobble_px=1.5", "bend_px=3&wobble_px=0.5&mirrored=1"}) {
    SimSpec spec = parse_sim_spec(std::string("ls5000?width_px=600&height_px=600&") + settings);
    const ScanWindow window{.x_px = 100, .y_px = 200, .width_px = 64, .n_lines = 32};
    std::vector<float> coarse(64UL * 32 * kChannels), fine(coarse.size());
    const ScanGeometry geometry = geometry_of(spec, spec.sensor);
    ScanRenderer(make_film(spec.film), spec.optics, window, geometry).transmittance(0, 32, coarse);
    spec.optics.cells_per_px = 16;
    ScanRenderer(make_film(spec.film), spec.optics, window, geometry).transmittance(0, 32, fine);
    double sum = 0;
    for (std::size_t i = 0; i < fine.size(); ++i) {
      sum += (coarse[i] - fine[i]) * static_cast<double>(coarse[i] - fine[i]);
    }
    EXPECT_LT(std::sqrt(sum / static_cast<double>(fine.size())), 6e-5) << settings;
  }
}

}  // namespace
}  // namespace reseau::sim
