// Registration and colour against the truth of the simulated film, which shares no code with what
// is measured: two scenes, three angles, two blurs, and the things that real film does.
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/line/memory_line_source.h"
#include "core/reconstruct/reconstruct.h"
#include "drivers/sim/simulate.h"
#include "tests/support/picture.h"

namespace reseau {
namespace {

struct Measured {
  double registration_px = 0, delta_e_mean = 0, delta_e_max = 0;
  int n_patches = 0;
};

Measured measure(const std::string& query) {
  const sim::SimSpec spec = sim::parse_sim_spec("ls5000?width_px=800&height_px=800&" + query);
  const sim::SimulatedScan scan = sim::simulate_frame(spec);
  const MemoryLineSource source(scan.format, scan.samples);
  const Registration registration = register_screen(source, {}, {}, {});
  EXPECT_TRUE(registration.found) << registration.reason;
  if (!registration.found) return {};
  Measured result;
  const sim::FilmTruth& truth = scan.truth;
  result.registration_px = test::map_error_px(
      registration.map,
      [&](double x, double y) {
        const auto s = truth.screen_from_scan(x, y);
        return std::array<double, 2>{s.u, s.v};
      },
      scan.format.width_px, scan.format.n_lines);
  ReconstructOptions options;
  options.white_level = spec.sensor.clear_level;
  test::MemorySink sink;
  (void)reconstruct(source, registration, options, sink, {}, {});
  EXPECT_TRUE(sink.ended);
  const test::PatchErrors patches = test::flat_patches(
      sink, [&](double x, double y) { return truth.process_rgb(x, y); }, 100);
  result.delta_e_mean = patches.mean;
  result.delta_e_max = patches.max;
  result.n_patches = patches.n;
  fmt::print("{}: registration {:.4f} px rms, patches dE00 {:.3f} mean {:.3f} max of {}\n", query,
             result.registration_px, result.delta_e_mean, result.delta_e_max, result.n_patches);
  return result;
}

class FilmAccuracy : public testing::TestWithParam<std::string> {};

// The product promises 0.10 px and a mean of 4; these bounds are what it reaches, with room for
// other compilers, so that a step back is seen.
TEST_P(FilmAccuracy, RegistersAndGivesTheColoursOfTheScene) {
  const Measured m = measure(GetParam());
  EXPECT_LT(m.registration_px, 0.05);
  EXPECT_GE(m.n_patches, 5);
  EXPECT_LT(m.delta_e_mean, 1.0);
  EXPECT_LT(m.delta_e_max, 3.0);
}

INSTANTIATE_TEST_SUITE_P(ScenesAnglesBlurs, FilmAccuracy,
                         testing::Values("scene=chart&angle=23&blur_px=0.6",
                                         "scene=chart&angle=67&blur_px=0.6",
                                         "scene=chart&angle=-35&blur_px=0.6",
                                         "scene=chart&angle=23&blur_px=1.2&ir_blur_px=1.3",
                                         "scene=chart&angle=67&blur_px=1.2&ir_blur_px=1.3",
                                         "scene=chart&angle=-35&blur_px=1.2&ir_blur_px=1.3",
                                         "scene=natural&angle=23&blur_px=0.6",
                                         "scene=natural&angle=67&blur_px=0.6",
                                         "scene=natural&angle=-35&blur_px=0.6",
                                         "scene=natural&angle=23&blur_px=1.2&ir_blur_px=1.3",
                                         "scene=natural&angle=67&blur_px=1.2&ir_blur_px=1.3",
                                         "scene=natural&angle=-35&blur_px=1.2&ir_blur_px=1.3"));
INSTANTIATE_TEST_SUITE_P(RealFilm, FilmAccuracy,
                         testing::Values("scene=chart&angle=23&mirrored=1&bend_px=4",
                                         "scene=natural&angle=5&bend_px=5&noise=0.006",
                                         "scene=chart&angle=23&fade=0.6",
                                         "scene=chart&angle=23&period_um=25"));

// A wide block shows many bright tiles, whose sum spectrum once held each line several times over
// and left no room for the right pair; the diagonal lattice u + v, u - v then fitted as neatly.
TEST(FilmRegistration, WideFramesAreNotTakenForTheDiagonalLattice) {
  const sim::SimSpec spec =
      sim::parse_sim_spec("ls5000?width_px=3000&height_px=520&scene=natural&angle=23&noise=0.001");
  const sim::SimulatedScan scan = sim::simulate_frame(spec);
  const Registration registration =
      register_screen(MemoryLineSource(scan.format, scan.samples), {}, {}, {});
  ASSERT_TRUE(registration.found) << registration.reason;
  EXPECT_NEAR(registration.angle_deg, 23, 0.1);
  EXPECT_NEAR(registration.period_um[0], 49.6, 0.4);
}

TEST(FilmRegistration, PlainSilverAndEmptyGateHaveNoScreen) {
  for (const std::string film : {"none", "empty"}) {
    const sim::SimulatedScan scan =
        sim::simulate_frame(sim::parse_sim_spec("ls5000?width_px=500&height_px=700&film=" + film));
    const MemoryLineSource source(scan.format, scan.samples);
    const Registration registration = register_screen(source, {}, {}, {});
    EXPECT_FALSE(registration.found) << film << " confidence " << registration.confidence;
    EXPECT_FALSE(registration.reason.empty());
    EXPECT_EQ(registration.screen, "none");
  }
}

}  // namespace
}  // namespace reseau
