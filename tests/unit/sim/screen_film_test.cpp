// Elements of every screen as the general film paints them: areas, places, convergence.
#include <algorithm>
#include <cmath>
#include <complex>
#include <iostream>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "drivers/sim/simulate.h"

namespace reseau::sim {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr const char* kScreens[] = {"dufay",
                                    "dufay_gawain",
                                    "dufay_penichon",
                                    "dufay_cornwell_clyne_color",
                                    "dufay_cornwell_clyne_bw",
                                    "spicer_dufay_blue",
                                    "spicer_dufay_green",
                                    "dioptichrome",
                                    "improved_dioptichrome",
                                    "omnicolore",
                                    "paget",
                                    "finlay",
                                    "thames",
                                    "joly",
                                    "warner_powrie"};

FilmSpec film_of(const std::string& settings) {
  return parse_sim_spec("ls5000?width_px=2000&height_px=2000&" + settings).film;
}

// Mean area of every set of dyes under a window that falls smoothly to zero, so that it does not
// matter which part of a period its ends hold.
std::array<double, kDyeSets> mean_areas(const FilmSpec& spec, int per_px, int side_px) {
  const ElementPainter painter(spec);
  std::array<double, kDyeSets> sum{};
  double total = 0;
  PlaneRow row;
  const auto window = [&](double at) {
    const double w = 0.5 - 0.5 * std::cos(2 * kPi * at / side_px);
    return w * w;
  };
  constexpr int kFirst = 320;
  for (int j = 0; j < side_px * per_px; ++j) {
    painter.areas(kFirst + cell_offset_px(j, per_px), kFirst, side_px, per_px, row);
    const double wy = window((j + 0.5) / per_px);
    for (int s = 0; s < per_px; ++s) {
      for (int i = 0; i < side_px; ++i) {
        const double w = wy * window(i + (s + 0.5) / per_px);
        total += w;
        for (std::size_t k = 0; k < painter.sets().size(); ++k) {
          sum[static_cast<std::size_t>(painter.sets()[k])] +=
              w * static_cast<double>(row.phase(static_cast<int>(k), s)[i]);
        }
      }
    }
  }
  for (double& v : sum) v /= total;
  return sum;
}

TEST(ScreenFilm, ElementsOfEveryScreenHaveTheirArea) {
  double worst = 0;
  for (const char* screen : kScreens) {
    for (const char* angle : {"23", "0", "-61"}) {
      const FilmSpec spec =
          film_of("period_um=60&screen=" + std::string(screen) + "&angle=" + angle);
      const auto areas = mean_areas(spec, 2, 160);
      const auto expected = describe_screen(spec.screen).areas;
      EXPECT_NEAR(expected[0] + expected[1] + expected[2], 1, 1e-12);
      double error = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        error = std::max(error, std::abs(areas[std::size_t{1} << k] - expected[k]));
      }
      EXPECT_LT(error, 3e-4) << screen << " at " << angle;
      worst = std::max(worst, error);
      if (*angle == '2') {
        std::cout << screen << ": R G B " << expected[0] << " " << expected[1] << " " << expected[2]
                  << ", error " << error << "\n";
      }
    }
  }
  std::cout << "largest error of an area: " << worst << "\n";
  RecordProperty("largest_area_error", std::to_string(worst));
}

TEST(ScreenFilm, EveryElementCoversItsMiddle) {
  for (const char* screen : kScreens) {
    const FilmSpec spec = film_of("angle=10&phase_u=0&phase_v=0&screen=" + std::string(screen));
    const ElementPainter painter(spec);
    const auto middles = describe_screen(spec.screen).middles;
    const ScreenGradient g = painter.screen().gradient();
    const double det = g.u_x * g.v_y - g.u_y * g.v_x;
    PlaneRow row;
    for (std::size_t k = 0; k < 3; ++k) {
      const double u = middles[k].x, v = middles[k].y;
      const double x = (g.v_y * u - g.u_y * v) / det, y = (g.u_x * v - g.v_x * u) / det;
      const int px = static_cast<int>(std::floor(x + 0.5));
      const int first = static_cast<int>(std::floor(px / 16.0)) * 16;
      painter.areas(y, first, 16, 1, row);
      const auto slot = std::ranges::find(painter.sets(), 1 << k) - painter.sets().begin();
      EXPECT_NEAR(row.phase(static_cast<int>(slot), 0)[px - first], 1, 1e-5) << screen << " " << k;
    }
  }
}

TEST(ScreenFilm, AreasOfTheDufaycolorAreThoseOfTheMicrograph) {
  const auto areas = describe_screen(film_of("").screen).areas;
  EXPECT_NEAR(areas[0], 21.0 / 49.9, 1e-12);
  EXPECT_NEAR(areas[1], 28.9 / 49.9 * 22.7 / 49.6, 1e-12);
  EXPECT_NEAR(areas[2], 28.9 / 49.9 * 26.9 / 49.6, 1e-12);
  const auto paget = describe_screen(film_of("screen=paget").screen).areas;
  EXPECT_NEAR(paget[2], 2 * 63.0 * 63.0 / (148.0 * 148.0), 1e-12);
  EXPECT_NEAR(paget[2], 0.364, 0.002);  // counted by Pledge 1913
  EXPECT_NEAR(paget[0], 0.318, 0.002);
}

TEST(ScreenFilm, SettingsOfTheScreenDoNotDependOnTheirOrder) {
  const ScreenSpec a = film_of("screen=paget&period_u_um=100").screen;
  const ScreenSpec b = film_of("period_u_um=100&screen=paget").screen;
  EXPECT_EQ(a.period_u_um, 100);
  EXPECT_EQ(b.period_u_um, 100);
  EXPECT_EQ(b.period_v_um, 148);
}

TEST(ScreenFilm, OverlapsAndGapsHaveTheirAreaAndNothingIsLost) {
  // Three borders a period, each 3 of 60 um wide.
  for (const char* print : {"overlap_um=3", "overlap_um=-3", "overlap_um=-3&gap=dark"}) {
    const auto areas =
        mean_areas(film_of("screen=joly&period_um=60&" + std::string(print)), 2, 160);
    double sum = 0;
    for (const double a : areas) sum += a;
    EXPECT_NEAR(sum, 1, 1e-6);
    for (const std::size_t dye : {1U, 2U, 4U}) EXPECT_NEAR(areas[dye], 17.0 / 60, 2e-4) << print;
    if (std::string(print) == "overlap_um=3") {
      for (const std::size_t pair : {3U, 5U, 6U}) EXPECT_NEAR(areas[pair], 3.0 / 60, 2e-4);
    } else {
      EXPECT_NEAR(areas[std::string(print) == "overlap_um=-3" ? 0 : kOpaque], 9.0 / 60, 2e-4);
    }
  }
  // The discs of a Thames plate: rings of 2 um about radius r.
  const FilmSpec thames = film_of("screen=thames&period_um=60&overlap_um=-2");
  const double r = describe_screen(thames.screen).shapes[0].radius_um;
  const auto areas = mean_areas(thames, 4, 160);
  const double ring = 2 * kPi * ((r + 1) * (r + 1) - (r - 1) * (r - 1)) / 3600;
  EXPECT_NEAR(areas[0], ring, 3e-4);
}

// Where the lines of the film lie, found by correlation with the map: displacement in pixels.
double map_error_px(const FilmSpec& spec, int y0, int x0, int n_px) {
  const auto film = make_film(spec);
  const PlacedScreen screen(spec);
  CellRow row;
  std::complex<double> sum = 0;
  for (int j = 0; j < 4 * 96; ++j) {
    const double y = y0 + cell_offset_px(j, 4);
    film->cells(y, x0, n_px, 4, row);
    const double wy = 0.5 - 0.5 * std::cos(2 * kPi * (j + 0.5) / 384);
    for (int s = 0; s < 4; ++s) {
      for (int i = 0; i < n_px; ++i) {
        const double t = (i + (s + 0.5) / 4) / n_px;
        const double w = wy * (0.5 - 0.5 * std::cos(2 * kPi * t));
        const double v = screen.screen_from_scan(x0 + i + cell_offset_px(s, 4), y).v;
        sum += w * static_cast<double>(row.phase(kInfrared, s)[i]) *
               std::polar(1.0, -2 * kPi * (v - 0.5));
      }
    }
  }
  const double period_px = spec.screen.period_v_um / spec.frame.pixel_um;
  return std::arg(sum) / (2 * kPi) * period_px;
}

TEST(ScreenFilm, TheMapIsExactUnderEveryDeformation) {
  // A colour that only red elements record: the infrared shows the red lines, at v = 0.5.
  auto raster = std::make_shared<SceneRaster>();
  raster->width_px = raster->height_px = 1;
  raster->rgb = {0.8F, 0.0F, 0.0F};
  double worst = 0;
  for (const char* deformation :
       {"general=1", "bend_px=6", "mirrored=1", "warp_px=4&warp_length_px=90",
        "warp_px=2&warp_length_px=900", "warp_px=6&warp_length_px=700", "radial=-0.006",
        "perspective_x=0.02&perspective_y=-0.01", "curl_um=800", "angle=-61&axes=86",
        "mirrored=1&warp_px=3&warp_length_px=120&radial=0.004&curl_um=-500"}) {
    FilmSpec spec = film_of("border_px=0&scene=image&" + std::string(deformation));
    spec.raster = raster;
    for (const int x0 : {16, 960, 1888}) {
      const double error = map_error_px(spec, x0, x0, 96);
      EXPECT_LT(std::abs(error), 4e-3) << deformation << " at " << x0;
      worst = std::max(worst, std::abs(error));
    }
  }
  std::cout << "largest displacement of rendered lines against the map: " << worst << " px\n";
  RecordProperty("map_error_px", std::to_string(worst));
}

TEST(ScreenFilm, CurlKeepsTheLengthOfTheFilm) {
  const FilmSpec flat = film_of(""), curled = film_of("curl_um=800");
  const PlacedScreen a(flat), b(curled);
  // Along the row of pixels through the middle: arc length by small steps of height and place.
  const double centre = 999.5;
  double arc = 0;
  constexpr int kSteps = 100000;
  for (int i = 0; i < kSteps; ++i) {
    const double dx = 900.0 / kSteps, x = centre + i * dx;
    arc += std::hypot(dx, (b.height_um(x + dx) - b.height_um(x)) / flat.frame.pixel_um);
  }
  const ScreenPoint straight = a.screen_from_scan(centre + arc, 400);
  const ScreenPoint bent = b.screen_from_scan(centre + 900, 400);
  EXPECT_NEAR(bent.u, straight.u, 1e-7);
  EXPECT_NEAR(bent.v, straight.v, 1e-7);
  EXPECT_GT(arc, 905);
  EXPECT_NEAR(b.height_um(centre + 1000), 800, 1e-9);
}

TEST(ScreenFilm, GeneralAndFastPathAgree) {
  const std::string plain = "ls5000?width_px=240&height_px=200&noise=0&scene=natural";
  const SimulatedScan fast = simulate_frame(parse_sim_spec(plain));
  const SimulatedScan general = simulate_frame(parse_sim_spec(plain + "&general=1"));
  int largest = 0;
  for (std::size_t y = 16; y < 184; ++y) {
    for (std::size_t c = 0; c < 4; ++c) {
      for (std::size_t x = 16; x < 224; ++x) {
        const std::size_t at = (y * 4 + c) * 240 + x;
        largest = std::max(largest, std::abs(int{fast.samples[at]} - int{general.samples[at]}));
      }
    }
  }
  EXPECT_LE(largest, 2);
}

TEST(ScreenFilm, SmallerCellsConvergeWithTheSquareOfTheirSide) {
  for (const char* screen : {"dufay", "paget", "thames"}) {
    const auto render = [&](int cells) {
      SimSpec spec = parse_sim_spec("ls5000?width_px=400&height_px=400&noise=0&general=1&screen=" +
                                    std::string(screen));
      spec.optics.cells_per_px = cells;
      const ScanWindow window{.x_px = 80, .y_px = 80, .width_px = 48, .n_lines = 48};
      const ScanRenderer renderer(make_film(spec.film), spec.optics, window);
      std::vector<float> light(48UL * 48 * kChannels);
      renderer.transmittance(0, 48, light);
      return light;
    };
    const std::vector<float> finest = render(16);
    const auto error = [&](int cells) {
      const std::vector<float> light = render(cells);
      double sum = 0;
      for (std::size_t i = 0; i < light.size(); ++i) {
        const double d = static_cast<double>(light[i] - finest[i]);
        sum += d * d;
      }
      return std::sqrt(sum / static_cast<double>(light.size()));
    };
    const double e2 = error(2), e4 = error(4), e8 = error(8);
    std::cout << screen << ": rms against 16 cells per pixel, 2: " << e2 << "  4: " << e4
              << "  8: " << e8 << "\n";
    EXPECT_LT(e4, 2e-4) << screen;
    EXPECT_LT(e8, e4 / 2.5) << screen;
    EXPECT_LT(e4, e2 / 2.5) << screen;
  }
}

constexpr const char* kEverything =
    "ls5000?width_px=200&height_px=160&scene=natural&grain=0.2&hd_gamma=1.4&spread_um=3&"
    "silver_spread_um=2&position_noise_um=0.7&width_noise_um=0.7&missing=0.02&overlap_um=1&dust="
    "900&"
    "scratches=60&bubbles=200&faded_areas=0.7&stains=0.5&warp_px=3&warp_length_px=120&curl_um=300&"
    "radial=-0.006&dyes=harrison_horner&ir_leak=0.2&outside_px=12&taking=dufay&mirrored=1";

TEST(ScreenFilm, CellsDependOnTheirPlaceOnly) {
  const auto film = make_film(parse_sim_spec(kEverything).film);
  const auto again = make_film(parse_sim_spec(kEverything).film);
  CellRow whole, part;
  for (const double y : {31.125, 31.375, 60.0, 12.875}) {  // also off the grid, also backwards
    film->cells(y, -16, 240, 4, whole);
    again->cells(y + 40, -16, 240, 4, part);  // fills the rows of other places
    again->cells(y + 0.25, -16, 240, 4, part);
    again->cells(y, -16, 240, 4, part);
    for (int c = 0; c < kChannels; ++c) {
      for (int k = 0; k < 240 * 4; ++k) {
        ASSERT_EQ(part.phase(c, 0)[k], whole.phase(c, 0)[k]) << y << " " << c << " " << k;
      }
    }
    // Another window: the same but for the rounding of places.
    again->cells(y, 48, 64, 4, part);
    for (int c = 0; c < kChannels; ++c) {
      for (int s = 0; s < 4; ++s) {
        for (int i = 0; i < 64; ++i) {
          ASSERT_NEAR(part.phase(c, s)[i], whole.phase(c, s)[64 + i], 1e-5) << y << " " << c;
        }
      }
    }
  }
}

TEST(ScreenFilm, EveryNuisanceKeepsTransmittancesPhysical) {
  const SimulatedScan a = simulate_frame(parse_sim_spec(kEverything));
  const SimulatedScan b = simulate_frame(parse_sim_spec(kEverything));
  EXPECT_EQ(a.samples, b.samples);
  const auto film = make_film(parse_sim_spec(kEverything).film);
  CellRow row;
  for (double y = -3; y < 163; y += 0.75) {
    film->cells(y, -32, 272, 4, row);
    for (int c = 0; c < kChannels; ++c) {
      for (int k = 0; k < 272 * 4; ++k) {
        ASSERT_GE(row.phase(c, 0)[k], 0.0F);
        ASSERT_LT(row.phase(c, 0)[k], 2.0F);  // grain scatters about the mean
      }
    }
  }
}

}  // namespace
}  // namespace reseau::sim
