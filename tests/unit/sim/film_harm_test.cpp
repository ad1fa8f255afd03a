// Dust, scratches, bubbles, stains, faded places, the edge of the film, and the truth about them.
#include <algorithm>
#include <cmath>
#include <iostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "drivers/sim/simulate.h"

namespace reseau::sim {
namespace {

constexpr const char* kClean = "ls5000?width_px=400&height_px=300&noise=0&general=1&scene=natural";

struct Pair {
  SimulatedScan clean, harmed;
};
Pair scan_with(const std::string& harm) {
  return {simulate_frame(parse_sim_spec(kClean)),
          simulate_frame(parse_sim_spec(std::string(kClean) + "&" + harm))};
}

std::vector<float> mask_of(const FilmTruth& truth) {
  std::vector<float> mask(400UL * 300);
  for (std::size_t y = 0; y < 300; ++y) {
    truth.harm_row(static_cast<double>(y), std::span(mask).subspan(y * 400, 400));
  }
  return mask;
}

TEST(Damage, IsWhereTheMaskSaysAndNowhereElse) {
  for (const char* harm : {"dust=800&dust_um=30", "scratches=60", "bubbles=300&bubble_um=60"}) {
    const Pair pair = scan_with(harm);
    const std::vector<float> mask = mask_of(pair.harmed.truth);
    const double covered =
        static_cast<double>(std::ranges::count_if(mask, [](float m) { return m > 0.2F; }));
    EXPECT_GT(covered, 500) << harm;
    EXPECT_LT(covered, 60000) << harm;
    std::size_t different = 0, outside = 0;
    for (std::size_t y = 8; y < 292; ++y) {
      for (std::size_t x = 8; x < 392; ++x) {
        const std::size_t at = (y * 4 + 3) * 400 + x;
        if (pair.clean.samples[at] == pair.harmed.samples[at]) continue;
        ++different;
        bool near = false;
        for (std::size_t j = y - 6; j <= y + 6; ++j) {
          for (std::size_t i = x - 6; i <= x + 6; ++i) near = near || mask[j * 400 + i] > 0;
        }
        outside += near ? 0 : 1;
      }
    }
    EXPECT_GT(different, 500U) << harm;
    EXPECT_EQ(outside, 0U) << harm;
  }
}

TEST(Damage, DustIsDarkInEveryChannelAndABaredPlaceBright) {
  const Pair dusty = scan_with("dust=800&dust_um=40");
  const std::vector<float> mask = mask_of(dusty.harmed.truth);
  for (std::size_t c = 0; c < 4; ++c) {
    double with = 0, without = 0;
    for (std::size_t y = 0; y < 300; ++y) {
      for (std::size_t x = 0; x < 400; ++x) {
        if (mask[y * 400 + x] < 0.6F) continue;
        with += dusty.harmed.samples[(y * 4 + c) * 400 + x];
        without += dusty.clean.samples[(y * 4 + c) * 400 + x];
      }
    }
    EXPECT_LT(with, 0.5 * without) << c;
  }
  const Pair scratched = scan_with("scratches=60");
  std::size_t brighter = 0, darker = 0;
  for (std::size_t k = 0; k < scratched.clean.samples.size(); ++k) {
    brighter += scratched.harmed.samples[k] > scratched.clean.samples[k] + 500 ? 1 : 0;
    darker += scratched.harmed.samples[k] + 500 < scratched.clean.samples[k] ? 1 : 0;
  }
  EXPECT_GT(brighter, 1000U);  // emulsion scratches
  EXPECT_GT(darker, 1000U);    // base scratches
}

TEST(Damage, StainsAndFadedPlacesLeaveTheInfraredAlone) {
  // Both vary over hundreds of pixels: a large frame, seen coarsely.
  for (const char* harm : {"stains=0.8", "faded_areas=0.9"}) {
    const ScanWindow window{.width_px = 200, .n_lines = 150, .pitch = 8};
    const std::string film = "ls5000?width_px=1600&height_px=1200&noise=0&general=1";
    const SimulatedScan clean = simulate_window(parse_sim_spec(film), window);
    const SimulatedScan harmed = simulate_window(parse_sim_spec(film + "&" + harm), window);
    std::size_t changed = 0;
    for (std::size_t row = 0; row < 600; ++row) {
      for (std::size_t x = 0; x < 200; ++x) {
        const std::size_t at = row * 200 + x;
        if (row % 4 == 3) {
          ASSERT_EQ(clean.samples[at], harmed.samples[at]) << harm;
        }
        changed += clean.samples[at] != harmed.samples[at] ? 1 : 0;
      }
    }
    EXPECT_GT(changed, 2000U) << harm;
    EXPECT_LT(changed, 88000U) << harm;  // other places are whole
  }
}

TEST(FilmEdge, BareLightLiesBesideTheFilm) {
  const SimulatedScan scan = simulate_frame(parse_sim_spec(
      "ls5000?width_px=200&height_px=60&noise=0&outside_px=40&rebate_px=10&level=0.5"));
  for (std::size_t y = 10; y < 50; ++y) {
    for (std::size_t c = 0; c < 4; ++c) {
      const std::uint16_t* line = scan.samples.data() + (y * 4 + c) * 200;
      EXPECT_NEAR(line[20], 32767, 2);
      EXPECT_NEAR(line[180], 32767, 2);
    }
    // The clear rebate has its réseau: infrared is clear, blue is not.
    EXPECT_NEAR(scan.samples[(y * 4 + 3) * 200 + 45], 32767, 400);
    EXPECT_LT(scan.samples[(y * 4 + 2) * 200 + 45], 24000);
  }
}

TEST(FilmTruth, SilverIsWhatAPerfectInfraredChannelShows) {
  for (const char* settings : {"", "&spread_um=3&hd_gamma=1.3", "&screen=thames&mirrored=1",
                               "&film=none", "&scene=star"}) {
    SimSpec spec = parse_sim_spec(std::string(kClean) + settings);
    spec.optics.blur_px[3] = 0.001;
    spec.optics.cells_per_px = 4;
    const SimulatedScan scan = simulate_frame(spec);
    std::vector<float> silver(400);
    for (const std::size_t y : {20U, 151U, 280U}) {
      scan.truth.silver_row(static_cast<double>(y), silver);
      for (std::size_t x = 0; x < 400; ++x) {
        const double seen = scan.samples[(y * 4 + 3) * 400 + x] / 65535.0 / 0.9;
        ASSERT_NEAR(silver[x], seen, 3e-4) << settings << " " << x << " " << y;
      }
    }
  }
}

TEST(FilmTruth, KnowsTheNameOfTheScreen) {
  const auto name = [](const char* spec) {
    return FilmTruth(parse_sim_spec(spec).film, {.width_px = 10, .n_lines = 10}).screen_name();
  };
  EXPECT_EQ(name("ls5000?screen=spicer_dufay_blue"), "spicer-dufay-blue");
  EXPECT_EQ(name("ls5000?film=paget"), "paget");
  EXPECT_EQ(name("ls5000?film=dufaycolor-gawain"), "dufaycolor-gawain");
  EXPECT_EQ(name("ls5000?screen=thames&film=dufay"), "thames") << "film=dufay names no other";
  EXPECT_EQ(name("ls5000"), "dufaycolor");
  EXPECT_EQ(name("ls5000?film=none"), "");
}

TEST(FilmTruth, ProcessRgbHasNeitherGrainNorHarm) {
  const std::string harm = "&grain=0.3&dust=800&bubbles=200&spread_um=4&stains=1&faded_areas=1";
  const FilmSpec clean = parse_sim_spec(kClean).film, harmed = parse_sim_spec(kClean + harm).film;
  const ScanWindow window{.width_px = 400, .n_lines = 300};
  const FilmTruth a(clean, window), b(harmed, window);
  for (int y = 5; y < 300; y += 37) {
    for (int x = 5; x < 400; x += 41) EXPECT_EQ(a.process_rgb(x, y), b.process_rgb(x, y));
  }
}

TEST(SimSpec, RefusesDeformationsThatHaveNoPlace) {
  for (const char* bad : {"ls5000?radial=0.01&frames=2", "ls5000?perspective_y=0.01&frames=3",
                          "ls5000?warp_px=20&warp_length_px=60", "ls5000?screen=autochrome",
                          "ls5000?width_px=100&outside_px=60", "ls5000?grain=0.9",
                          "ls5000?spread_um=0.5", "ls5000?silver_spread_um=0.01"}) {
    EXPECT_ANY_THROW((void)parse_sim_spec(bad)) << bad;
  }
}

}  // namespace
}  // namespace reseau::sim
