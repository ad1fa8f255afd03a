#include <algorithm>
#include <cmath>
#include <fstream>
#include <numeric>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "drivers/sim/sensor.h"
#include "drivers/sim/simulate.h"

namespace reseau::sim {
namespace {

// Mean of one channel over the inside of a patch, as a fraction of full scale.
double patch_mean(const SimulatedScan& scan, const Patch& patch, int channel, double margin_px) {
  double sum = 0;
  int n = 0;
  const int width = scan.format.width_px;
  for (int y = static_cast<int>(std::ceil(patch.y0 + margin_px)); y <= patch.y1 - margin_px; ++y) {
    for (int x = static_cast<int>(std::ceil(patch.x0 + margin_px)); x <= patch.x1 - margin_px;
         ++x) {
      sum += scan.samples[static_cast<std::size_t>((y * 4 + channel) * width + x)];
      ++n;
    }
  }
  return n == 0 ? NAN : sum / n / 65535;
}

TEST(FilmTruth, MeanOfAPatchIsTheAreaWeightedMixtureOfItsElements) {
  const SimSpec spec =
      parse_sim_spec("sim:ls5000?width_px=1200&height_px=1000&noise=0.002&level=0.9");
  const SimulatedScan scan = simulate_frame(spec);
  const std::array<double, 3> area = scan.truth.area_fractions();
  EXPECT_NEAR(area[0], 0.4208, 5e-5);
  EXPECT_NEAR(area[1], 0.2651, 5e-5);
  EXPECT_NEAR(area[2], 0.3141, 5e-5);
  const ElementResponse response = element_response(0);
  const std::vector<Patch> patches = scan.truth.patches();
  ASSERT_EQ(patches.size(), 24U);
  for (const Patch& patch : patches) {
    for (int c = 0; c < 4; ++c) {
      double expected = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        const double seen = c == 3 ? 1.0 : response[k][static_cast<std::size_t>(c)];
        expected += 0.9 * area[k] * patch.rgb[k] * seen;
      }
      // The window holds no whole number of periods: about one element row in twenty is cut.
      EXPECT_NEAR(patch_mean(scan, patch, c, 3), expected, 0.02 * expected + 1e-4)
          << "channel " << c << " at " << patch.x0 << ", " << patch.y0;
    }
    const auto truth = scan.truth.process_rgb((patch.x0 + patch.x1) / 2, (patch.y0 + patch.y1) / 2);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(truth[k], patch.rgb[k], 1e-6);
  }
}

TEST(FilmTruth, ScreenRepeatsAlongItsLatticeVectors) {
  const SimSpec spec =
      parse_sim_spec("ls5000?angle=23&axes=88.9&period_u_um=49.58&period_v_um=48.9");
  const FilmTruth truth(spec.film, {.width_px = 100, .n_lines = 100});
  const double degree = std::acos(-1.0) / 180;
  const double pu = 49.58 / 6.35, pv = 48.9 / 6.35;
  const ScreenPoint a = truth.screen_from_scan(10, 20);
  const ScreenPoint b =
      truth.screen_from_scan(10 + pu * std::sin(23 * degree), 20 + pu * std::cos(23 * degree));
  EXPECT_NEAR(b.u - a.u, 1, 1e-12);
  EXPECT_NEAR(b.v - a.v, 0, 1e-12);
  const double across = (23 - 88.9) * degree;
  const ScreenPoint c =
      truth.screen_from_scan(10 + pv * std::sin(across), 20 + pv * std::cos(across));
  EXPECT_NEAR(c.u - a.u, 0, 1e-12);
  EXPECT_NEAR(c.v - a.v, 1, 1e-12);
}

TEST(FilmTruth, ElementsLieWhereTheMapSaysThem) {
  // A colour that only red elements let through: infrared is bright on the red lines, v = 0.5.
  for (const char* settings : {"", "&mirrored=1", "&bend_px=4", "&wobble_px=1", "&angle=-70"}) {
    const SimSpec spec = parse_sim_spec(
        std::string("ls5000?width_px=600&height_px=500&noise=0&ir_blur_px=0.2") + settings);
    const SimulatedScan scan = simulate_frame(spec);
    const Patch patch = scan.truth.patches()[14];
    ASSERT_DOUBLE_EQ(patch.rgb[0], 0.43F);
    double on_red = 0, off_red = 0;
    int n_on = 0, n_off = 0;
    for (int y = static_cast<int>(patch.y0) + 8; y < patch.y1 - 8; ++y) {
      for (int x = static_cast<int>(patch.x0) + 8; x < patch.x1 - 8; ++x) {
        const double v = scan.truth.screen_from_scan(x, y).v;
        const double distance = std::abs(v - std::floor(v) - 0.5);
        const double value = scan.samples[static_cast<std::size_t>((y * 4 + 3) * 600 + x)];
        if (distance < 0.08) on_red += value, ++n_on;
        if (distance > 0.42) off_red += value, ++n_off;
      }
    }
    EXPECT_NEAR(on_red / n_on / 65535, 0.9 * 0.43, 0.004) << settings;
    EXPECT_NEAR(off_red / n_off / 65535, 0.9 * 0.035, 0.004) << settings;
  }
}

TEST(FilmTruth, MirroringReversesTheLineAndTheHandedness) {
  const SimSpec plain = parse_sim_spec("ls5000?width_px=300&height_px=200&noise=0&scene=natural");
  const SimSpec turned =
      parse_sim_spec("ls5000?width_px=300&height_px=200&noise=0&scene=natural&mirrored=1");
  const SimulatedScan a = simulate_frame(plain), b = simulate_frame(turned);
  for (std::size_t row = 0; row < 800; ++row) {
    for (std::size_t x = 0; x < 300; ++x) {
      ASSERT_NEAR(a.samples[row * 300 + x], b.samples[row * 300 + 299 - x], 6) << row << " " << x;
    }
  }
  const auto handedness = [](const FilmTruth& truth) {
    const ScreenGradient g = truth.mean_gradient();
    return g.u_x * g.v_y - g.u_y * g.v_x;
  };
  EXPECT_GT(handedness(a.truth), 0);
  EXPECT_LT(handedness(b.truth), 0);
  EXPECT_NEAR(a.truth.screen_from_scan(20, 30).u, b.truth.screen_from_scan(279, 30).u, 1e-12);
}

TEST(FilmTruth, BendStaysBelowItsLimitAndTheMapIsSmooth) {
  const SimSpec bent = parse_sim_spec("ls5000?bend_px=6"), flat = parse_sim_spec("ls5000");
  const ScanWindow all{.width_px = 3946, .n_lines = 5959};
  const FilmTruth a(bent.film, all), b(flat.film, all);
  const ScreenGradient g = b.mean_gradient();
  const double det = g.u_x * g.v_y - g.u_y * g.v_x;
  double largest = 0;
  for (int y = 0; y < 5959; y += 97) {
    for (int x = 0; x < 3946; x += 83) {
      const ScreenPoint p = a.screen_from_scan(x, y), q = b.screen_from_scan(x, y);
      const double du = p.u - q.u, dv = p.v - q.v;
      largest = std::max({largest, std::abs((g.v_y * du - g.u_y * dv) / det),
                          std::abs((g.u_x * dv - g.v_x * du) / det)});
    }
  }
  EXPECT_LE(largest, 6);
  EXPECT_GT(largest, 4);
}

TEST(Simulate, DoesNotDependOnHowTheWindowIsCut) {
  const SimSpec spec = parse_sim_spec("ls5000?width_px=400&height_px=300&scene=natural&bend_px=2");
  const ScanWindow window{.x_px = 13, .y_px = 21, .width_px = 150, .n_lines = 120};
  const ScanRenderer renderer(make_film(spec.film), spec.optics, window);
  const std::size_t per_line = 150 * kChannels;
  SensorPass pass;
  pass.level.fill(0.9);
  std::vector<float> light(per_line * 120);
  std::vector<std::uint16_t> whole(light.size()), parts(light.size());
  renderer.transmittance(0, 120, light);
  digitise(light, window, 0, spec.sensor, pass, whole);
  // Backwards, in pieces of odd sizes.
  int last = 120;
  for (int n = 1; last > 0; n = n * 3 % 17 + 1) {
    const int first = std::max(0, last - n);
    const std::size_t size = per_line * static_cast<std::size_t>(last - first);
    std::vector<float> piece(size);
    renderer.transmittance(first, last - first, piece);
    digitise(piece, window, first, spec.sensor, pass,
             std::span(parts).subspan(per_line * static_cast<std::size_t>(first), size));
    last = first;
  }
  EXPECT_EQ(whole, parts);

  const SimulatedScan inner =
      simulate_window(spec, {.x_px = 40, .y_px = 50, .width_px = 60, .n_lines = 30});
  const SimulatedScan outer = simulate_window(spec, window);
  for (std::size_t y = 0; y < 30; ++y) {
    for (std::size_t c = 0; c < 4; ++c) {
      for (std::size_t x = 0; x < 60; ++x) {
        ASSERT_EQ(inner.samples[(y * 4 + c) * 60 + x],
                  outer.samples[((y + 29) * 4 + c) * 150 + x + 27]);
      }
    }
  }
}

TEST(Simulate, NoiseHasTheAskedForSizeAndIsNewInEveryPass) {
  const SimSpec spec = parse_sim_spec("ls5000?film=empty&width_px=512&height_px=512&noise=0.01");
  SimSpec quiet = spec;
  quiet.film.seed = 2;
  const SimulatedScan a = simulate_frame(spec), b = simulate_frame(quiet);
  double sum = 0, squares = 0, products = 0;
  for (std::size_t i = 0; i < a.samples.size(); ++i) {
    const double x = a.samples[i] / 65535.0 - 0.9, y = b.samples[i] / 65535.0 - 0.9;
    sum += x;
    squares += x * x;
    products += x * y;
  }
  const auto n = static_cast<double>(a.samples.size());
  // Photon noise scales with the root of the signal, 0.9 of full scale.
  const double expected = 0.01 * std::sqrt(0.04 + 0.96 * 0.9);
  EXPECT_NEAR(sum / n, 0, 5e-5);
  EXPECT_NEAR(std::sqrt(squares / n), expected, 0.005 * expected);
  EXPECT_NEAR(products / squares, 0, 0.005);
}

TEST(Simulate, DepthAndLevelAreTheAskedForOnes) {
  const SimulatedScan scan = simulate_frame(
      parse_sim_spec("ls5000?film=empty&width_px=32&height_px=32&noise=0&bits=14&level=0.5"));
  EXPECT_EQ(scan.format.significant_bits, 14);
  // 8192 of 16383, scaled to 16 bits.
  for (const std::uint16_t v : scan.samples) EXPECT_EQ(v, 32770);
}

TEST(Simulate, CoarsePitchKeepsTheMeanOfAPatch) {
  const SimSpec spec = parse_sim_spec("ls5000?width_px=1200&height_px=1000&noise=0");
  const SimulatedScan full = simulate_frame(spec);
  const double fine = patch_mean(full, full.truth.patches()[18], 3, 4);
  for (const int pitch : {2, 4, 14}) {
    const ScanWindow window{.width_px = 1200 / pitch, .n_lines = 1000 / pitch, .pitch = pitch};
    const SimulatedScan scan = simulate_window(spec, window);
    EXPECT_DOUBLE_EQ(scan.format.x_dpi, 4000.0 / pitch);
    EXPECT_NEAR(patch_mean(scan, scan.truth.patches()[18], 3, 1), fine, 0.01) << pitch;
  }
}

TEST(FilmTruth, RowsAreThePointsInARow) {
  const SimSpec spec = parse_sim_spec(
      "ls5000?width_px=200&height_px=200&scene=natural&bend_px=2&wobble_px=1&mirrored=1");
  for (const int pitch : {1, 3}) {
    const ScanWindow window{.x_px = 7, .y_px = 30, .width_px = 40, .n_lines = 20, .pitch = pitch};
    const FilmTruth truth(spec.film, window, geometry_of(spec, spec.sensor));
    std::vector<float> r(40), g(40), b(40);
    std::vector<ScreenPoint> screen(40);
    truth.process_row(11, {r, g, b});
    truth.screen_row(11, screen);
    for (std::size_t x = 0; x < 40; ++x) {
      const auto rgb = truth.process_rgb(static_cast<double>(x), 11);
      EXPECT_NEAR(r[x], rgb[0], 1e-5);
      EXPECT_NEAR(g[x], rgb[1], 1e-5);
      EXPECT_NEAR(b[x], rgb[2], 1e-5);
      EXPECT_EQ(screen[x].u, truth.screen_from_scan(static_cast<double>(x), 11).u);
    }
  }
}

TEST(Simulate, TheHolderBesideTheFilmIsOpaque) {
  const SimSpec spec = parse_sim_spec("ls5000?width_px=100&height_px=100&noise=0");
  const SimulatedScan scan = simulate_window(spec, {.x_px = -400, .width_px = 900, .n_lines = 2});
  EXPECT_EQ(scan.samples[0], 0);
  EXPECT_EQ(scan.samples[899], 0);
  const SimulatedScan film = simulate_window(spec, {.width_px = 100, .n_lines = 2});
  for (std::size_t row = 0; row < 8; ++row) {
    for (std::size_t x = 0; x < 100; ++x) {
      ASSERT_EQ(scan.samples[row * 900 + 400 + x], film.samples[row * 100 + x]);
    }
  }
  const SimulatedScan beside = simulate_window(spec, {.x_px = 1000, .width_px = 10, .n_lines = 2});
  for (const std::uint16_t v : beside.samples) EXPECT_EQ(v, 0);
}

TEST(SimSpec, RefusesWhatItDoesNotKnowAndSaysWhatItDoes) {
  const auto message = [](const char* name) {
    try {
      (void)parse_sim_spec(name);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_NE(message("ls5000?angel=23").find("angle=-360..360"), std::string::npos);
  EXPECT_NE(message("ls5000?film=kodachrome").find("\"dufay\""), std::string::npos);
  for (const char* bad : {"ls5000?angle", "ls5000?angle=", "ls5000?angle=x", "ls5000?angle=1e9",
                          "ls5000?angle=nan", "ls5000?noise=-1", "ls5000?cells=2.5",
                          "ls5000?width_px=16&border_px=8", "ls5000?fragment=100"}) {
    EXPECT_NE(message(bad), "accepted") << bad;
  }
  const SimSpec spec = parse_sim_spec("sim:ls50?film=none&&mirrored=1&blur_px=0.5&seed=12");
  EXPECT_EQ(spec.model, "ls50");
  EXPECT_EQ(spec.film.kind, FilmKind::kPlain);
  EXPECT_TRUE(spec.film.mirrored);
  EXPECT_EQ(spec.optics.blur_px[1], 0.5);
  EXPECT_EQ(spec.optics.blur_px[3], 0.7);
  EXPECT_EQ(spec.film.seed, 12U);
}

TEST(SimSpec, TheReadmeNamesEverySettingWithItsRange) {
  std::ifstream file(std::string(RESEAU_SIM_DIR) + "/README.md");
  std::stringstream readme;
  readme << file.rdbuf();
  std::istringstream help(sim_key_help());
  int n = 0;
  for (std::string line; std::getline(help, line); ++n) {
    const std::size_t equals = line.find('='), gap = line.find("  ", equals);
    const std::string key = line.substr(2, equals - 2);
    const std::string meaning = line.substr(gap + 2);
    std::string range = line.substr(equals + 1, gap - equals - 1);
    for (std::size_t at = 0; (at = range.find('|', at)) != std::string::npos;) {
      range.replace(at, 1, ", ");
    }
    const std::string row = "| `" + key + "` | " + range + " | " + meaning + " |";
    EXPECT_NE(readme.str().find(row), std::string::npos) << row;
  }
  EXPECT_GT(n, 30);
}

TEST(Chart, PatchesOfAFullFrameHoldMoreThanFourteenElementsEachWay) {
  const SimSpec spec = parse_sim_spec("ls5000");
  const FilmTruth truth(spec.film, {.width_px = 3946, .n_lines = 5959});
  const double element_px = 49.9 / 6.35;
  for (const Patch& patch : truth.patches()) {
    EXPECT_GT(patch.x1 - patch.x0, 14 * element_px);
    EXPECT_GT(patch.y1 - patch.y0, 14 * element_px);
  }
}

}  // namespace
}  // namespace reseau::sim
