// Every screen with scenes of every kind, and a Dufaycolor with every nuisance: what is rendered is
// light, the same each time, and near what finer cells give.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "drivers/sim/film/make_film.h"
#include "drivers/sim/scan_renderer.h"
#include "drivers/sim/simulate.h"
#include "drivers/sim/window_render.h"

namespace reseau::sim {
namespace {

std::vector<float> rendered(const SimSpec& spec, const ScanWindow& window, int cells, int fewest) {
  OpticsSpec optics = spec.optics;
  optics.cells_per_px = cells;
  optics.fewest_cells_per_px = fewest;
  std::vector<float> light(static_cast<std::size_t>(window.width_px) *
                           static_cast<std::size_t>(window.n_lines) * kChannels);
  ScanRenderer(make_film(spec.film), optics, window, geometry_of(spec, spec.sensor))
      .transmittance(0, window.n_lines, light);
  return light;
}

// Largest difference from cells twice as fine, as estimate_error() scales it.
double largest_error(const std::string& settings) {
  const SimSpec spec =
      parse_sim_spec("ls5000?width_px=160&height_px=120&border_px=0&optics=coolscan&" + settings);
  ScanWindow window = frame_window(spec);
  window.x_px += 60;
  window.y_px += 50;
  window.width_px = 40;
  window.n_lines = 6;
  const int cells = cells_used(*make_film(spec.film), spec.optics, 1, true);
  const std::vector<float> used = rendered(spec, window, cells, 1);
  const std::vector<float> finer = rendered(spec, window, 2 * cells, 6);
  double largest = 0;
  for (std::size_t i = 0; i < used.size(); ++i) {
    EXPECT_TRUE(std::isfinite(used[i])) << settings;
    EXPECT_GT(used[i], -1e-3F) << settings;
    EXPECT_LT(used[i], 1.001F) << settings;
    largest = std::max(largest, 4.0 / 3 * std::abs(static_cast<double>(used[i]) - finer[i]));
  }
  std::printf("%-60s %2d cells: %.1e\n", settings.c_str(), cells, largest);
  return largest;
}

TEST(FilmSweep, EveryScreenAndSceneConverges) {
  for (const char* screen : {"dufay", "spicer_dufay_blue", "dioptichrome", "improved_dioptichrome",
                             "omnicolore", "paget", "finlay", "thames", "joly"}) {
    for (const char* scene : {"chart24", "natural"}) {
      const std::string settings = std::string("angle=23&screen=") + screen + "&scene=" + scene;
      EXPECT_LT(largest_error(settings), 1.2e-4) << settings;
    }
  }
}

TEST(FilmSweep, TheSameTwice) {
  const SimSpec spec =
      parse_sim_spec("ls5000?optics=coolscan&screen=thames&scene=chart24&grain=0.1");
  const ScanWindow window{.x_px = 300, .y_px = 200, .width_px = 40, .n_lines = 6};
  EXPECT_EQ(rendered(spec, window, 0, 1), rendered(spec, window, 0, 1));
}

TEST(FilmSweep, DufaycolorConvergesAtEveryAngleToATenThousandth) {
  for (const char* angle : {"7", "23", "45"}) {
    for (const char* scene : {"chart24", "natural"}) {
      const std::string settings = std::string("angle=") + angle + "&scene=" + scene;
      EXPECT_LT(largest_error(settings), 1e-4) << settings;
    }
  }
}

TEST(FilmSweep, EveryNuisanceConverges) {
  for (const char* nuisance :
       {"hd_gamma=1.4", "spread_um=5", "silver_spread_um=4", "overlap_um=2", "overlap_um=-2",
        "position_noise_um=1&width_noise_um=1", "missing=0.1", "faded_areas=0.8", "stains=0.8",
        "warp_px=3&warp_length_px=150", "perspective_x=0.02&radial=-0.01", "curl_um=500",
        "mirrored=1", "dyes=harrison_horner&fade=0.3&ir_leak=0.1", "scene=zone&finest=0.5",
        "scene=star&spokes=6", "scene=edges", "grain=0.1", "dust=900&scratches=40&bubbles=300"}) {
    // Grain, harm and scenes of steps have detail of their own finer than cells.
    const std::string settings = std::string("angle=23&") + nuisance;
    const bool fine = settings.find("grain") != std::string::npos ||
                      settings.find("dust") != std::string::npos ||
                      settings.find("edges") != std::string::npos;
    EXPECT_LT(largest_error(settings), fine ? 5e-4 : 2e-4) << settings;
  }
}

}  // namespace
}  // namespace reseau::sim
