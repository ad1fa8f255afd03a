// Screens other than Dufaycolor on simulated film: found, named, followed, and made into a picture.
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

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
  std::string film;
  std::vector<std::string> names;  // any of these: what the period and the colours leave open
};

void expect_found(const OtherScreen& screen) {
  constexpr int kSide = 800;
  const auto spec = sim::parse_sim_spec(
      fmt::format("ls5000?width_px={0}&height_px={0}&scene=chart&{1}", kSide, screen.film));
  const sim::SimulatedScan scan = sim::simulate_frame(spec);
  const MemoryLineSource source(scan.format, scan.samples);
  const Registration found = register_screen(source, {}, {}, {});
  ASSERT_TRUE(found.found) << screen.film << ": " << found.reason;
  bool known = false;
  for (const std::string& name : screen.names)
    known = known || found.screen == name || found.runner_up == name;
  EXPECT_TRUE(known) << screen.film << ": " << found.screen << " or " << found.runner_up;
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
  expect_found({"screen=dioptichrome-b&angle=10", {"dioptichrome-b"}});
}
TEST(OtherScreens, BlueLines) {
  expect_found({"screen=omnicolore&angle=-35", {"omnicolore", "improved-dioptichrome-b"}});
}
TEST(OtherScreens, SpicerDufay) {
  expect_found({"screen=spicer-dufay-blue&angle=40", {"spicer-dufay-blue"}});
}
TEST(OtherScreens, SquaresOfTwoSizes) {
  expect_found({"screen=finlay&angle=20", {"finlay", "thames"}});
}
TEST(OtherScreens, Discs) { expect_found({"screen=thames&angle=64", {"thames", "finlay"}}); }

}  // namespace
}  // namespace reseau
