// Scenes finer than a pixel: every sample is the mean of the light over its cell.
#include <algorithm>
#include <cmath>
#include <iostream>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "drivers/sim/simulate.h"

namespace reseau::sim {
namespace {

constexpr double kPi = std::numbers::pi;
using Function = double (*)(double x, double y);

std::vector<float> red_row(const Scene& scene, double y, double x0, double side, std::size_t n) {
  std::vector<float> r(n), g(n), b(n);
  scene.cells(y, x0, side, {r, g, b});
  return r;
}

// Mean over a square by brute force.
template <typename F>
double mean_over(const F& f, double x, double y, double side, int n) {
  double sum = 0;
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      sum += f(x + ((i + 0.5) / n - 0.5) * side, y + ((j + 0.5) / n - 0.5) * side);
    }
  }
  return sum / n / n;
}

TEST(ZoneScene, CellsAreMeansOfTheWave) {
  constexpr double kFinest = 2.0;  // cycles per pixel: far beyond what pixels can show
  const auto scene = make_zone_scene(200, 240, kFinest);
  const auto exact = [&](double x, double y) {
    const double dx = x - 99.5, dy = y - 119.5;
    return 0.5 + 0.45 * std::cos(kPi * kFinest / 100 * (dx * dx + dy * dy));
  };
  double worst = 0;
  for (const double side : {0.25, 1.0}) {
    for (const double y : {119.5, 90.2, 33.0, 4.1}) {
      const std::vector<float> row = red_row(*scene, y, 3, side, 190);
      for (std::size_t i = 0; i < row.size(); i += 7) {
        const double x = 3 + static_cast<double>(i) * side;
        worst = std::max(worst,
                         std::abs(static_cast<double>(row[i]) - mean_over(exact, x, y, side, 24)));
      }
    }
  }
  std::cout << "zone plate, cells against brute force: " << worst << "\n";
  EXPECT_LT(worst, 0.35 * kFinest / 100);
}

TEST(ZoneScene, PixelsAreTheMeanOfTheirCells) {
  const auto scene = make_zone_scene(200, 200, 1.5);
  std::vector<double> sum(150, 0.0);
  for (int k = 0; k < 4; ++k) {
    const std::vector<float> cells =
        red_row(*scene, 20 + cell_offset_px(k, 4), 10 + cell_offset_px(0, 4), 0.25, 600);
    for (std::size_t i = 0; i < cells.size(); ++i) {
      sum[i / 4] += static_cast<double>(cells[i]) / 16;
    }
  }
  const std::vector<float> pixels = red_row(*scene, 20, 10, 1, 150);
  for (std::size_t i = 0; i < 150; ++i) EXPECT_NEAR(pixels[i], sum[i], 2e-3);
}

TEST(StarScene, CellsAreMeansOfTheSpokesAlsoAtTheCentre) {
  const auto scene = make_star_scene(101, 101, 72);
  // The spokes begin at a disc where they would be finer than 1.5 cycles per px, within 0.4 of its
  // radius.
  const double disc = 72 / (2 * std::numbers::pi * 1.5);
  const auto exact = [disc](double x, double y) {
    const double r = std::hypot(x - 50, y - 50);
    const double t = std::clamp((r - disc) / (0.4 * disc) + 0.5, 0.0, 1.0);
    return 0.5 + 0.45 * t * t * (3 - 2 * t) * std::cos(72 * std::atan2(y - 50, x - 50));
  };
  double worst = 0;
  for (const double side : {0.25, 1.0}) {
    for (const double y : {50.0, 51.3, 57.0, 62.5, 90.0}) {
      const std::vector<float> row = red_row(*scene, y, 30, side, 40);
      for (std::size_t i = 0; i < row.size(); ++i) {
        const double x = 30 + static_cast<double>(i) * side;
        worst = std::max(worst,
                         std::abs(static_cast<double>(row[i]) - mean_over(exact, x, y, side, 64)));
      }
    }
  }
  std::cout << "star, cells against brute force: " << worst << "\n";
  EXPECT_LT(worst, 2e-3);
}

TEST(EdgesScene, ABorderIsTheExactShareOfBothColours) {
  const auto scene = make_edges_scene(300, 200, 7);
  ASSERT_EQ(scene->edges().size(), 6U);
  for (const Edge& edge : scene->edges()) {
    const double c = std::cos(edge.angle_deg * kPi / 180), s = std::sin(edge.angle_deg * kPi / 180);
    const auto exact = [&](double x, double y) {
      const bool right = (x - edge.x) * c - (y - edge.y) * s > 0;
      return right ? edge.right[0] : edge.left[0];
    };
    for (const double y : {edge.y, edge.y + 17.3}) {
      const std::vector<float> row = red_row(*scene, y, edge.x - 6, 0.5, 24);
      for (std::size_t i = 0; i < row.size(); ++i) {
        const double x = edge.x - 6 + 0.5 * static_cast<double>(i);
        EXPECT_NEAR(row[i], mean_over(exact, x, y, 0.5, 200), 4e-3);
      }
    }
    EXPECT_NEAR(red_row(*scene, edge.y0 + 1, edge.x0 + 1, 1, 1)[0], edge.left[0], 1e-6);
    EXPECT_NEAR(red_row(*scene, edge.y1 - 1, edge.x1 - 1, 1, 1)[0], edge.right[0], 1e-6);
  }
}

TEST(EdgesScene, TheTruthKnowsWhereTheBordersLie) {
  for (const char* settings : {"", "&mirrored=1", "&outside_px=20"}) {
    const SimSpec spec = parse_sim_spec(
        std::string("ls5000?width_px=300&height_px=200&scene=edges&edge_angle=-12") + settings);
    const FilmTruth truth(spec.film, {.width_px = 300, .n_lines = 200});
    ASSERT_EQ(truth.edges().size(), 6U);
    for (const Edge& edge : truth.edges()) {
      const double c = std::cos(edge.angle_deg * kPi / 180);
      const double s = std::sin(edge.angle_deg * kPi / 180);
      for (const double along : {-25.0, 0.0, 25.0}) {
        const double x = edge.x + along * s, y = edge.y + along * c;
        for (std::size_t k = 0; k < 3; ++k) {
          EXPECT_NEAR(truth.process_rgb(x - 2, y)[k], edge.left[k], 1e-6) << settings;
          EXPECT_NEAR(truth.process_rgb(x + 2, y)[k], edge.right[k], 1e-6) << settings;
        }
      }
    }
  }
}

std::shared_ptr<SceneRaster> ramp_raster(int width, int height) {
  auto raster = std::make_shared<SceneRaster>();
  raster->width_px = width;
  raster->height_px = height;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double wave = 0.5 + 0.4 * std::sin(x * 1.9) * std::cos(y * 2.3);
      for (const double v : {wave, 0.01 * x, 0.02 * y}) {
        raster->rgb.push_back(static_cast<float>(v));
      }
    }
  }
  return raster;
}

TEST(ImageScene, CellsAreMeansOfTheInterpolatedRaster) {
  const auto raster = ramp_raster(40, 30);
  const auto at = [&](int x, int y) {
    x = std::clamp(x, 0, 39);
    y = std::clamp(y, 0, 29);
    return static_cast<double>(raster->rgb[static_cast<std::size_t>(3 * (y * 40 + x))]);
  };
  // Finer and coarser than the raster: 80 x 60, and 10 x 7.5 pixels for 40 x 30.
  for (const double size : {80.0, 10.0}) {
    const auto scene = make_image_scene(raster, size, size * 0.75);
    const double scale = 40 / size;
    const auto exact = [&](double x, double y) {
      const double rx = scale * (x + 0.5) - 0.5, ry = scale * (y + 0.5) - 0.5;
      const double fx = rx - std::floor(rx), fy = ry - std::floor(ry);
      const int ix = static_cast<int>(std::floor(rx)), iy = static_cast<int>(std::floor(ry));
      return (1 - fy) * ((1 - fx) * at(ix, iy) + fx * at(ix + 1, iy)) +
             fy * ((1 - fx) * at(ix, iy + 1) + fx * at(ix + 1, iy + 1));
    };
    for (const double side : {0.25, 1.0}) {
      for (const double y : {0.0, 3.3, 6.7}) {
        const std::vector<float> row = red_row(*scene, y, -0.6, side, 12);
        for (std::size_t i = 0; i < row.size(); ++i) {
          const double x = -0.6 + side * static_cast<double>(i);
          EXPECT_NEAR(row[i], mean_over(exact, x, y, side, 100), 2e-4);
        }
      }
    }
  }
}

TEST(ImageScene, CoversThePictureAndCropsEvenly) {
  const auto raster = ramp_raster(60, 30);  // twice as wide as high
  const auto scene = make_image_scene(raster, 30, 30);
  std::vector<float> r(30), g(30), b(30);
  scene->row(10, 0, {r, g, b});
  for (std::size_t i = 0; i < 30; ++i) {
    EXPECT_NEAR(g[i], 0.01 * (15 + static_cast<double>(i)), 1e-6);
    EXPECT_NEAR(b[i], 0.2, 1e-6);
  }
}

TEST(ImageScene, RefusesWhatIsNoPicture) {
  EXPECT_THROW((void)make_film(parse_sim_spec("ls5000?scene=image").film), InputError);
  const auto bad = std::make_shared<SceneRaster>(*ramp_raster(4, 4));
  bad->rgb[5] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW((void)make_image_scene(bad, 10, 10), InputError);
  bad->rgb.pop_back();
  EXPECT_THROW((void)make_image_scene(bad, 10, 10), InputError);
}

TEST(SweepScene, RunsThroughTheSpectrum) {
  const auto scene = make_sweep_scene(310, 100);
  std::vector<float> r(310), g(310), b(310);
  scene->row(0, 0, {r, g, b});
  // 450, 540 and 640 nm.
  EXPECT_GT(b[52], 5 * r[52]);
  EXPECT_GT(g[145], 5 * r[145]);
  EXPECT_GT(r[248], 5 * g[248]);
  std::vector<float> low(310);
  scene->row(100, 0, {low, g, b});
  EXPECT_NEAR(low[248] / r[248], std::pow(10, -1.5), 1e-3);
}

// Light as fine as the elements goes through each where it lies: on a film without grain or spread
// the mean infrared of a zone plate is that of its mean, and the silver behind an element shows
// the fringes that cross it.
TEST(FineScene, IsIntegratedOverTheElementsNotSampled) {
  const SimSpec spec =
      parse_sim_spec("ls5000?width_px=320&height_px=320&scene=zone&finest=2&noise=0&border_px=0");
  const SimulatedScan scan = simulate_frame(spec);
  const auto& area = scan.truth.area_fractions();
  double sum = 0;
  for (std::size_t y = 40; y < 280; ++y) {
    for (std::size_t x = 40; x < 280; ++x) sum += scan.samples[(y * 4 + 3) * 320 + x];
  }
  const double mean = sum / (240.0 * 240) / 65535;
  EXPECT_NEAR(area[0] + area[1] + area[2], 1, 1e-12);
  // The wave's own mean over the square adds a little to 0.5.
  EXPECT_NEAR(mean, 0.9 * 0.5, 0.9 * 0.006);
  // Where the fringes are finer than a pixel, nothing of them is left to alias.
  double variance = 0;
  for (std::size_t y = 150; y < 170; ++y) {
    for (std::size_t x = 240; x < 280; ++x) {  // 1 to 1.5 cycles per pixel
      const double v = scan.samples[(y * 4 + 3) * 320 + x] / 65535.0 - 0.45;
      variance += v * v / (20 * 40);
    }
  }
  EXPECT_LT(std::sqrt(variance), 0.01);
}

}  // namespace
}  // namespace reseau::sim
