// Every screen with scenes of every kind, and a Dufaycolor with every nuisance: what is rendered is
// light, the same each time, and near what finer cells give.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "drivers/sim/film/make_film.h"
#include "drivers/sim/scan_renderer.h"
#include "drivers/sim/simulate.h"
#include "drivers/sim/widest.h"
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
      EXPECT_LT(largest_error(settings), 1e-4) << settings;
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
    const std::string settings = std::string("angle=23&") + nuisance;
    EXPECT_LT(largest_error(settings), 1e-4) << settings;
  }
}

// A film, a scene, a lens, an angle and two nuisances by lot.
std::string any_film(std::mt19937& lots) {
  const auto one_of = [&lots](const auto& list) { return list[lots() % std::size(list)]; };
  static constexpr std::array kFilms{
      "dufay",  "dufay", "spicer_dufay_green", "dioptichrome", "omnicolore", "paget", "finlay",
      "thames", "joly",  "warner_powrie"};
  static constexpr std::array kScenes{"chart24", "chart24", "natural", "natural",
                                      "edges",   "zone",    "star",    "sweep"};
  static constexpr std::array kNuisances{"hd_gamma=1.4",
                                         "spread_um=4",
                                         "overlap_um=2",
                                         "overlap_um=-2&gap=dark",
                                         "position_noise_um=1&width_noise_um=1",
                                         "missing=0.1",
                                         "faded_areas=0.8&stains=0.8",
                                         "warp_px=2&warp_length_px=200",
                                         "perspective_x=0.02&radial=-0.01",
                                         "curl_um=60",
                                         "mirrored=1",
                                         "dyes=harrison_horner&fade=0.3&ir_leak=0.1",
                                         "grain=0.1",
                                         "dust=300&scratches=10&bubbles=100",
                                         "border_px=6&rebate_px=5&outside_px=4",
                                         "halo=0.1&focus_um=40",
                                         "taking=dufay"};
  const int angle = lots() % 3 == 0
                        ? 90 * static_cast<int>(lots() % 4) + static_cast<int>(lots() % 9) - 4
                        : static_cast<int>(lots() % 360);
  std::string settings = "film=" + std::string(one_of(kFilms)) + "&scene=" + one_of(kScenes);
  settings += "&angle=" + std::to_string(angle) + "&seed=" + std::to_string(lots() % 1000);
  return settings + "&" + one_of(kNuisances) + "&" + one_of(kNuisances);
}

// What a rendering says of itself is not less than what it errs by, against cells three times as
// fine in a place that was not looked at, which is not more than a ten-thousandth; nor is what it
// says.
void expect_honest(const std::string& settings, std::mt19937& lots) {
  const SimSpec spec =
      parse_sim_spec("ls5000?width_px=160&height_px=120&border_px=0&optics=coolscan&" + settings);
  const ScanWindow frame = frame_window(spec);
  const std::shared_ptr<const Film> film = make_film(spec.film);
  const RenderError said =
      estimate_error(film, spec.optics, frame, geometry_of(spec, spec.sensor), 3);
  ScanWindow window = frame;
  window.x_px += static_cast<int>(lots() % 140);
  window.y_px += static_cast<int>(lots() % 118);
  window.width_px = 16;
  window.n_lines = 2;
  const std::vector<float> used = rendered(spec, window, 0, 1);
  const std::vector<float> finest = rendered(spec, window, 3 * said.cells_per_px, 6);
  double largest = 0;
  for (std::size_t i = 0; i < used.size(); ++i) {
    largest = std::max(largest, std::abs(static_cast<double>(used[i]) - finest[i]));
  }
  std::printf("%-110s %2d cells: true %.1e, said %.1e\n", settings.c_str(), said.cells_per_px,
              largest, said.largest);
  EXPECT_LE(largest, said.largest) << settings;
  EXPECT_LE(largest, 1e-4) << settings;
  EXPECT_LE(said.largest, 1e-4) << settings;
}

TEST(FilmSweep, TheEstimateIsHonest) {
  std::mt19937 lots(7);
  for (const char* settings :
       {"angle=0&scene=natural", "angle=3&grain=0.1&dust=900", "angle=90&overlap_um=2",
        "angle=0&scene=natural&overlap_um=-2&spread_um=4&hd_gamma=1.4",
        "angle=90&overlap_um=-2&spread_um=4", "angle=23&overlap_um=-2&silver_spread_um=4",
        "angle=67&halo=0.1&focus_um=60&overlap_um=-2", "angle=33&warp_px=3&warp_length_px=150"}) {
    expect_honest(settings, lots);
  }
}

TEST(FilmSweep, TheEstimateIsHonestOfFilmsByLot) {
  constexpr int kFilms = 12;
  std::mt19937 lots(20261130);
  for (int k = 0; k < kFilms; ++k) {
    const std::string settings = any_film(lots);
    expect_honest(settings, lots);
  }
}

#if defined(__x86_64__)
// The loops for wide registers are the same numbers as those for any processor.
TEST(FilmSweep, WideAndNarrowLoopsGiveTheSameBytes) {
  if (!has_wide_registers()) GTEST_SKIP() << "this processor has no wide registers";
  for (const char* settings :
       {"angle=0&scene=natural", "angle=23&scene=chart24", "screen=paget&grain=0.1&dust=300",
        "film=none&scene=natural", "screen=thames&scene=zone&faded_areas=0.5&stains=0.5",
        "angle=90&overlap_um=2&hd_gamma=1.4&spread_um=2&optics=plain"}) {
    const SimSpec spec = parse_sim_spec(
        "ls5000?width_px=32&height_px=16&border_px=2&optics=coolscan&" + std::string(settings));
    const SimulatedScan wide = simulate_frame(spec);
    has_wide_registers() = false;
    const SimulatedScan narrow = simulate_frame(spec);
    has_wide_registers() = true;
    EXPECT_EQ(wide.samples, narrow.samples) << settings;
  }
}
#endif

// The tents of the same film as its even cells: two ways to the same light.
class EvenCells final : public Film {
 public:
  explicit EvenCells(std::shared_ptr<const Film> film) : film_(std::move(film)) {}
  [[nodiscard]] Edges edges() const override {
    Edges edges = film_->edges();
    edges.tents = false;
    return edges;
  }
  [[nodiscard]] Extent extent() const override { return film_->extent(); }
  void cells(double y, int first_px, int n_px, int per_px, CellRow& out) const override {
    film_->cells(y, first_px, n_px, per_px, out);
  }

 private:
  std::shared_ptr<const Film> film_;
};

TEST(FilmSweep, TentsGiveTheLightOfEvenCells) {
  for (const char* settings :
       {"angle=0&scene=natural", "angle=90&axes=90&screen=dioptichrome&grain=0.1",
        "angle=2&scene=natural&general=1&optics=plain"}) {
    const SimSpec spec = parse_sim_spec(
        "ls5000?width_px=160&height_px=120&border_px=0&optics=coolscan&" + std::string(settings));
    const std::shared_ptr<const Film> film = make_film(spec.film);
    ScanWindow window = frame_window(spec);
    window.x_px += 60;
    window.y_px += 50;
    window.width_px = 32;
    window.n_lines = 3;
    ASSERT_TRUE(takes_tents(*film, 1));
    OpticsSpec fine = spec.optics;
    fine.cells_per_px = 24;
    fine.fewest_cells_per_px = 6;
    std::vector<float> tents(32 * 3 * kChannels), even(tents.size());
    const ScanGeometry geometry = geometry_of(spec, spec.sensor);
    ScanRenderer(film, spec.optics, window, geometry).transmittance(0, 3, tents);
    ScanRenderer(std::make_shared<EvenCells>(film), fine, window, geometry)
        .transmittance(0, 3, even);
    double largest = 0;
    for (std::size_t i = 0; i < tents.size(); ++i) {
      largest = std::max(largest, std::abs(static_cast<double>(tents[i]) - even[i]));
    }
    std::printf("tents against 24 even cells, %s: largest %.1e\n", settings, largest);
    EXPECT_LT(largest, 1e-4) << settings;
  }
}

}  // namespace
}  // namespace reseau::sim
