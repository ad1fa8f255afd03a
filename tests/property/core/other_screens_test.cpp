// Screens other than Dufaycolor on simulated film: found, named, followed, and made into a picture.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/geometry/vec2.h"
#include "core/line/line_format.h"
#include "core/line/memory_line_source.h"
#include "core/reconstruct/reconstruct.h"
#include "drivers/sim/simulate.h"
#include "tests/support/picture.h"

namespace reseau {
namespace {

// rms distance of a map from the truth [px], whole and half periods, turns by 90 degrees and
// mirrors of the pattern aside.
double distance_px(const ScreenMap& map, const sim::FilmTruth& truth, int side_px) {
  double best = 1e300;
  for (const bool exchange : {false, true}) {
    for (const double sign_u : {1.0, -1.0}) {
      for (const double sign_v : {1.0, -1.0}) {
        std::array<double, 2> whole{};
        double sum = 0;
        int n = 0;
        for (int y = 8; y < side_px; y += 16) {
          for (int x = 8; x < side_px; x += 16, ++n) {
            const auto s = truth.screen_from_scan(x, y);
            const Vec2 m = map.screen_from_scan({double(x), double(y)});
            Vec2 off{m.x - sign_u * (exchange ? s.v : s.u), m.y - sign_v * (exchange ? s.u : s.v)};
            if (n == 0) whole = {std::round(2 * off.x) / 2, std::round(2 * off.y) / 2};
            off = off - Vec2{whole[0], whole[1]};
            const Vec2 px = map.jacobian({double(x), double(y)}).inverse() * off;
            sum += dot(px, px);
          }
        }
        best = std::min(best, std::sqrt(sum / n));
      }
    }
  }
  return best;
}

struct OtherScreen {
  std::string film, name;
};

void expect_found(const OtherScreen& screen) {
  constexpr int kSide = 800;
  const auto spec = sim::parse_sim_spec(
      fmt::format("ls5000?width_px={0}&height_px={0}&scene=chart&{1}", kSide, screen.film));
  const sim::SimulatedScan scan = sim::simulate_frame(spec);
  const MemoryLineSource source(scan.format, scan.samples);
  const Registration found = register_screen(source, {}, {}, {});
  ASSERT_TRUE(found.found) << screen.film << ": " << found.reason;
  EXPECT_EQ(found.screen, screen.name) << screen.film;
  EXPECT_GT(found.screen_probability, 0.9) << screen.film << ", else " << found.runner_up;
  EXPECT_LT(found.none_probability, 0.1) << screen.film;
  const double off = distance_px(found.map, scan.truth, kSide);
  ReconstructOptions options;
  options.white_level = spec.sensor.clear_level;
  test::MemorySink sink;
  (void)reconstruct(source, found, options, sink, {}, {});
  const test::PatchErrors patches = test::flat_patches(
      sink, [&](double x, double y) { return scan.truth.process_rgb(x, y); }, 50, 30);
  fmt::print(
      "{}: {} ({:.2f}), else {} ({:.2f}); {:.4f} px rms; patches {:.3f} mean {:.3f} max of {}\n",
      screen.film, found.screen, found.screen_probability, found.runner_up,
      found.runner_up_probability, off, patches.mean, patches.max, patches.n);
  EXPECT_LT(off, 0.02) << screen.film;
  EXPECT_GE(patches.n, 5) << screen.film;
  EXPECT_LT(patches.mean, 0.3) << screen.film;
  EXPECT_LT(patches.max, 1.0) << screen.film;
}

TEST(OtherScreens, GreenLines) {
  expect_found({"screen=dioptichrome-b&angle=10", "dioptichrome-b"});
}
TEST(OtherScreens, BlueLines) { expect_found({"screen=omnicolore&angle=-35", "omnicolore"}); }
TEST(OtherScreens, SpicerDufay) {
  expect_found({"screen=spicer-dufay-blue&angle=40", "spicer-dufay-blue"});
}
TEST(OtherScreens, SquaresOfTwoSizes) { expect_found({"screen=finlay&angle=20", "finlay"}); }
TEST(OtherScreens, Discs) { expect_found({"screen=thames&angle=64", "thames"}); }

// Screens that lie alike in the same colours are told apart by the sizes of their elements, soft
// and noisy scans too.
TEST(OtherScreens, SizesOfElementsGiveTheName) {
  for (const std::string name : {"omnicolore", "improved-dioptichrome-b", "paget", "thames"}) {
    const sim::SimulatedScan scan = sim::simulate_frame(sim::parse_sim_spec(
        "ls5000?width_px=520&height_px=520&scene=natural&angle=50&blur_px=1.3&noise=0.01&screen=" +
        name));
    const Registration found =
        register_screen(MemoryLineSource(scan.format, scan.samples), {}, {}, {});
    ASSERT_TRUE(found.found) << name << ": " << found.reason;
    fmt::print("{}: {} ({:.2f}), else {} ({:.2f})\n", name, found.screen, found.screen_probability,
               found.runner_up, found.runner_up_probability);
    EXPECT_EQ(found.screen, name);
    EXPECT_GT(found.screen_probability, 0.9) << name;
  }
}

TEST(OtherScreens, AndThePrintingOfADufaycolor) {
  for (const std::string name :
       {"dufaycolor", "dufaycolor-gawain", "dufaycolor-cornwell-clyne-bw"}) {
    const sim::SimulatedScan scan = sim::simulate_frame(sim::parse_sim_spec(
        "ls5000?width_px=420&height_px=420&scene=natural&angle=23&noise=0.004&screen=" + name));
    const Registration found =
        register_screen(MemoryLineSource(scan.format, scan.samples), {}, {}, {});
    ASSERT_TRUE(found.found) << name << ": " << found.reason;
    EXPECT_EQ(found.screen, "dufaycolor");
    EXPECT_EQ(found.printing, name);
    EXPECT_GT(found.printing_probability, 0.9) << name;
  }
}

// Screens of lines alone: v is known, and points from red over green to blue; u is a convention.
struct LinesAlone {
  std::string film;
  std::string name;
  double period_um;
};

void expect_lines(const LinesAlone& screen, bool infrared) {
  constexpr int kSide = 800;
  const auto spec =
      sim::parse_sim_spec(fmt::format("ls5000?width_px={0}&height_px={0}&{1}", kSide, screen.film));
  const sim::SimulatedScan scan = sim::simulate_frame(spec);
  LineFormat format = scan.format;
  std::vector<std::uint16_t> samples;
  if (infrared) {
    samples = scan.samples;
  } else {
    const std::size_t line = format.samples_per_line(), rgb = line / format.channels.size() * 3;
    for (std::size_t at = 0; at < scan.samples.size(); at += line) {
      const auto begin = scan.samples.begin() + static_cast<std::ptrdiff_t>(at);
      samples.insert(samples.end(), begin, begin + static_cast<std::ptrdiff_t>(rgb));
    }
    format.channels.resize(3);
  }
  const MemoryLineSource source(format, std::move(samples));
  const Registration found = register_screen(source, {}, {}, {});
  ASSERT_TRUE(found.found) << screen.film << ": " << found.reason;
  EXPECT_EQ(found.screen, screen.name);
  EXPECT_TRUE(found.lines_alone);
  EXPECT_FALSE(found.mirrored.has_value());
  EXPECT_EQ(norm(found.lattice_cy_per_px[0]), 0);
  EXPECT_NEAR(found.period_um[1], screen.period_um, 0.002 * screen.period_um);
  double sum = 0, whole = 0;
  int n = 0;
  for (const double sign : {1.0, -1.0}) {
    double square = 0;
    int count = 0;
    for (int y = 8; y < kSide; y += 16) {
      for (int x = 8; x < kSide; x += 16, ++count) {
        const Vec2 at{double(x), double(y)};
        double off = found.map.screen_from_scan(at).y - sign * scan.truth.screen_from_scan(x, y).v;
        if (count == 0) whole = std::round(off);
        off -= whole;
        square += off * off;
      }
    }
    if (n == 0 || square < sum) sum = square;
    n = count;
  }
  const double off_periods = std::sqrt(sum / n);
  fmt::print("{}: {} ({:.2f}), {:.4f} periods, {:.3f} px rms\n", screen.film, found.screen,
             found.screen_probability, off_periods, off_periods * found.period_px[1]);
  // Identity is a third of a period; this is a fiftieth of a line.
  EXPECT_LT(off_periods, 0.007) << screen.film;
}

TEST(LinesAlone, Joly) {
  expect_lines({"screen=joly&scene=chart&angle=23&seed=3", "joly", 300}, true);
}
TEST(LinesAlone, WarnerPowrieMirrored) {
  expect_lines({"screen=warner_powrie&scene=chart&angle=-50&mirrored=1", "warner-powrie", 127},
               true);
}
TEST(LinesAlone, WithoutInfrared) {
  expect_lines({"screen=warner_powrie&scene=natural&angle=90", "warner-powrie", 127}, false);
}

// One channel of a film: what can be known is the lattice and the map up to half a period of u.
sim::SimulatedScan one_channel(const std::string& film, int channel, int n_alike) {
  const auto spec = sim::parse_sim_spec(film);
  sim::SimulatedScan scan = sim::simulate_frame(spec);
  const auto width = static_cast<std::ptrdiff_t>(scan.format.width_px),
             n = static_cast<std::ptrdiff_t>(scan.format.n_channels());
  std::vector<std::uint16_t> samples;
  for (std::ptrdiff_t y = 0; y < scan.format.n_lines; ++y) {
    const auto begin = scan.samples.begin() + (y * n + channel) * width;
    for (int k = 0; k < n_alike; ++k) samples.insert(samples.end(), begin, begin + width);
  }
  scan.samples = std::move(samples);
  scan.format.channels.resize(static_cast<std::size_t>(n_alike));
  if (n_alike == 1) scan.format.channels = {Channel::kGrey};
  return scan;
}

TEST(WithoutColors, TheLatticeIsFoundAndTheRestGivenByHand) {
  for (const int n_alike : {1, 3}) {
    const sim::SimulatedScan scan =
        one_channel("ls5000?width_px=700&height_px=700&scene=natural&angle=17", 1, n_alike);
    const MemoryLineSource source(scan.format, scan.samples);
    RegisterOptions options;
    if (n_alike == 1) {
      EXPECT_THROW(static_cast<void>(register_screen(source, options, {}, {})), InputError);
    } else {
      EXPECT_FALSE(register_screen(source, options, {}, {}).found);
    }
    options.allow_grey = true;
    const Registration found = register_screen(source, options, {}, {});
    ASSERT_TRUE(found.found) << found.reason;
    EXPECT_EQ(found.identity, "unknown");
    EXPECT_NEAR(found.period_um[1], 49.9, 0.02);
    const double off = distance_px(found.map, scan.truth, 700);
    fmt::print("green, {} alike: {} ({:.2f}), {:.4f} px rms\n", n_alike, found.screen,
               found.screen_probability, off);
    EXPECT_LT(off, 0.05);

    options.exchange = true;
    options.screen = "dufaycolor";
    const Registration given = register_screen(source, options, {}, {});
    ASSERT_TRUE(given.found) << given.reason;
    EXPECT_EQ(given.identity, "given");
    EXPECT_EQ(given.screen, "dufaycolor");
    const Vec2 moved =
        given.map.screen_from_scan({300, 200}) - found.map.screen_from_scan({300, 200});
    EXPECT_NEAR(moved.x, 0.5, 1e-9);
    EXPECT_NEAR(moved.y, 0, 1e-9);
    options.screen = "paget";
    const Registration wrong = register_screen(source, options, {}, {});
    EXPECT_FALSE(wrong.found);
    EXPECT_NE(wrong.reason.find("paget"), std::string::npos) << wrong.reason;
  }
}

TEST(WithoutColors, WhatAChannelDoesNotShowIsSaid) {
  for (const int channel : {0, 3}) {  // red: squares alike; infrared: hardly anything
    const sim::SimulatedScan scan =
        one_channel("ls5000?width_px=500&height_px=500&scene=natural&angle=17", channel, 1);
    const MemoryLineSource source(scan.format, scan.samples);
    RegisterOptions options;
    options.allow_grey = true;
    const Registration found = register_screen(source, options, {}, {});
    if (found.found) {  // then rightly
      EXPECT_LT(distance_px(found.map, scan.truth, 500), 0.3) << channel;
    } else {
      fmt::print("channel {}: {}\n", channel, found.reason);
      EXPECT_FALSE(found.reason.empty());
    }
  }
}

}  // namespace
}  // namespace reseau
