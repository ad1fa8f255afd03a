// How many cells a rendering takes, and what is left of its error where edges run along their
// borders.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "drivers/sim/film/make_film.h"
#include "drivers/sim/scan_renderer.h"
#include "drivers/sim/simulate.h"
#include "drivers/sim/window_render.h"

namespace reseau::sim {
namespace {

int cells_of(const std::string& settings, bool full) {
  const SimSpec spec = parse_sim_spec("ls5000?" + settings);
  return cells_used(*make_film(spec.film), spec.optics, 1, full);
}

TEST(Cells, AreManyForEdgesAlongTheGridAndFewForOthers) {
  EXPECT_EQ(cells_of("angle=23", true), 6);
  EXPECT_EQ(cells_of("angle=23&optics=coolscan", true), 6);
  EXPECT_EQ(cells_of("angle=23", false), 6);
  // Tents know where an edge along their borders lies; a film of even cells needs more of them.
  EXPECT_EQ(cells_of("angle=0", true), 6);
  EXPECT_EQ(cells_of("angle=90&axes=90", true), 6);
  EXPECT_EQ(cells_of("angle=0&spread_um=3", true), 10);
  EXPECT_EQ(cells_of("angle=0&spread_um=1", true), 32) << "as many to a spread";
  EXPECT_EQ(cells_of("angle=0&spread_um=3&screen=thames", true), 16);
  EXPECT_EQ(cells_of("angle=0&cells=6", true), 6) << "what is asked for";
  EXPECT_EQ(cells_of("film=none&angle=0", true), 6) << "no elements, no edges";
  EXPECT_EQ(cells_of("film=none&scene=edges&edge_angle=-89", true), 16);
  EXPECT_EQ(cells_of("film=none&scene=edges&edge_angle=0", true), 24) << "black to white";
  // Dufaycolor's other edges are 0.6 degrees off square.
  EXPECT_EQ(cells_of("angle=90.6&axes=89.4&spread_um=3", true), 10);
  EXPECT_EQ(cells_of("angle=23&screen=thames", true), 16) << "round edges run along both axes";
  EXPECT_EQ(cells_of("angle=0&optics=coolscan", true), 6);
  EXPECT_EQ(cells_of("angle=0&optics=coolscan&grain=0.1", true), 8);
}

TEST(Cells, KeepTheEstimatedErrorAtEveryAngle) {
  for (const char* screen : {"dufay", "paget"}) {
    for (const char* angle : {"0", "10", "23"}) {
      const SimSpec spec =
          parse_sim_spec("ls5000?width_px=120&height_px=90&border_px=0&optics=coolscan&screen=" +
                         std::string(screen) + "&angle=" + angle);
      const ScanWindow window = frame_window(spec);
      const RenderError e = estimate_error(make_film(spec.film), spec.optics, window,
                                           geometry_of(spec, spec.sensor), 2);
      std::printf("%s at %s degrees: %d cells, rms %.1e, largest %.1e\n", screen, angle,
                  e.cells_per_px, e.rms, e.largest);
      EXPECT_LT(e.rms, 5e-5);
      EXPECT_LT(e.largest, 1e-4);
    }
  }
}

// Mean over a pixel of a step at 0 that a Gaussian has blurred, d from it.
double blurred_step(double d, double sigma) {
  const auto antiderivative = [sigma](double x) {
    const double t = x / sigma;
    return x * 0.5 * std::erfc(-t / std::numbers::sqrt2) +
           sigma * std::exp(-0.5 * t * t) / std::sqrt(2 * std::numbers::pi);
  };
  return antiderivative(d + 0.5) - antiderivative(d - 0.5);
}

TEST(Cells, AnEdgeAlongTheirBordersIsItsIntegral) {
  double worst = 0, worst_of_few = 0;
  for (const int cells : {0, 6}) {
    for (int phase = 0; phase < 12; ++phase) {
      // The picture begins at the border's end: the edge passes through the cells.
      SimSpec spec = parse_sim_spec(
          "ls5000?film=none&scene=edges&edge_angle=0&noise=0&width_px=180&height_px=120&border_"
          "px=" +
          std::to_string(10 + phase / 24.0));
      spec.optics.cells_per_px = cells;
      spec.optics.shift_x_px[3] = 1e-9;  // the full optics
      const ScanWindow window{.x_px = 0, .y_px = 30, .width_px = 180, .n_lines = 1};
      const FilmTruth truth(spec.film, window);
      std::vector<float> light(180 * kChannels);
      ScanRenderer(make_film(spec.film), spec.optics, window, geometry_of(spec, spec.sensor))
          .transmittance(0, 1, light);
      const std::vector<Edge> edges = truth_of(spec, frame_window(spec)).edges();
      ASSERT_FALSE(edges.empty());
      const Edge& edge = edges.front();
      // Without a réseau the silver is one band; black to white.
      const double left = edge.left[0], right = edge.right[0];
      ASSERT_GT(std::abs(right - left), 0.5);
      for (int x = static_cast<int>(edge.x) - 5; x <= edge.x + 5; ++x) {
        const double exact = left + (right - left) * blurred_step(x - edge.x, 0.6);
        const double error =
            std::abs(static_cast<double>(light[static_cast<std::size_t>(x)]) - exact);
        (cells == 0 ? worst : worst_of_few) = std::max(cells == 0 ? worst : worst_of_few, error);
      }
    }
  }
  std::printf("largest error of an edge along the cells: %.1e; with 6 cells: %.1e\n", worst,
              worst_of_few);
  EXPECT_LT(worst, 1e-4);
  EXPECT_GT(worst_of_few, 5e-4) << "the control: too few cells must show";
}

TEST(Cells, RenderedBandsAreTheWholeWindow) {
  const SimSpec spec =
      parse_sim_spec("ls5000?width_px=60&height_px=50&optics=coolscan&readings=3&bits=14");
  const SimulatedScan whole = simulate_frame(spec);
  const WindowRender render(spec, frame_window(spec));
  const std::size_t per_line = render.format().samples_per_line();
  for (const int n : {1, 7}) {
    for (int y = 0; y + n <= 50; y += n) {
      std::vector<std::uint16_t> band(per_line * static_cast<std::size_t>(n));
      render.lines(y, n, band);
      ASSERT_TRUE(std::equal(band.begin(), band.end(),
                             whole.samples.begin() + static_cast<std::ptrdiff_t>(
                                                         per_line * static_cast<std::size_t>(y))))
          << y;
    }
  }
}

}  // namespace
}  // namespace reseau::sim
