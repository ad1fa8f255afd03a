// Stage, lens geometry and sensor: what they do to the image and what the truth says of it.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/parallel.h"
#include "drivers/sim/scan_renderer.h"
#include "drivers/sim/sensor.h"
#include "drivers/sim/sensor_curves.h"
#include "drivers/sim/simulate.h"
#include "tests/unit/sim/test_films.h"

namespace reseau::sim {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(Stage, SineHasItsAmplitudeAndPeriod) {
  const Stage stage({.wave_px = 0.58, .wave_lines = 200, .sideways = 0.25}, 1);
  double sum = 0, low = 0, high = 0;
  for (int y = 0; y < 4000; ++y) {
    const StageError e = stage.error_at(y);
    sum += e.y * e.y;
    low = std::min(low, e.y);
    high = std::max(high, e.y);
    EXPECT_NEAR(e.x, 0.25 * e.y, 1e-12);
    EXPECT_NEAR(stage.error_at(y + 200).y, e.y, 1e-9);
  }
  EXPECT_NEAR(std::sqrt(sum / 4000), 0.41, 0.001);
  EXPECT_NEAR(high - low, 1.16, 1e-3);
}

TEST(Stage, JitterIsWhiteAndTheWalkIsARandomWalk) {
  const Stage jitter({.jitter_px = 0.2}, 7), walk({.walk_px = 0.01}, 7);
  constexpr int kN = 20000;
  double square = 0, next = 0, steps = 0, far = 0, step_next = 0;
  for (int y = -kN / 2; y < kN / 2; ++y) {
    const double a = jitter.error_at(y).y, b = jitter.error_at(y + 1).y;
    square += a * a, next += a * b;
    const double s = walk.error_at(y + 1).y - walk.error_at(y).y;
    const double t = walk.error_at(y + 2).y - walk.error_at(y + 1).y;
    steps += s * s, step_next += s * t;
    far += std::pow(walk.error_at(y + 400).y - walk.error_at(y).y, 2);
  }
  EXPECT_NEAR(std::sqrt(square / kN), 0.2, 0.003);
  EXPECT_NEAR(next / square, 0, 0.03);
  EXPECT_NEAR(std::sqrt(steps / kN), 0.01, 0.0002);
  EXPECT_NEAR(step_next / steps, 0, 0.03) << "steps do not know of each other";
  // After 400 lines 20 steps' worth; 50 independent stretches leave a fifth of uncertainty.
  EXPECT_NEAR(std::sqrt(far / kN), 0.2, 0.06);
  EXPECT_EQ(walk.error_at(0).y, 0);
  // Between lines: straight. Another seed: another stage. The same seed: the same, in any order.
  EXPECT_NEAR(jitter.error_at(10.25).y, 0.75 * jitter.error_at(10).y + 0.25 * jitter.error_at(11).y,
              1e-15);
  EXPECT_NE(Stage({.jitter_px = 0.2}, 8).error_at(3).y, jitter.error_at(3).y);
  EXPECT_EQ(Stage({.jitter_px = 0.2}, 7).error_at(-41).y, jitter.error_at(-41).y);
}

TEST(Stage, LargestIsNeverExceeded) {
  for (const StageSpec& spec :
       {StageSpec{.wobble_px = 1.5}, StageSpec{.wave_px = 0.6, .sideways = -1},
        StageSpec{.jitter_px = 0.3}, StageSpec{.walk_px = 0.02}}) {
    const Stage stage(spec, 3);
    const StageError most = stage.largest();
    for (int y = 0; y < 6000; ++y) {
      const StageError e = stage.error_at(y);
      ASSERT_LE(std::abs(e.x), most.x + 1e-12);
      ASSERT_LE(std::abs(e.y), most.y + 1e-12);
    }
  }
}

// A line is exposed at its own displaced place: a sinusoid shows it to the last digit.
TEST(Motion, EveryLineLooksWhereTheGeometrySays) {
  constexpr double kF = 0.21, kG = 0.08;
  OpticsSpec optics;
  optics.blur_px.fill(0.6);
  double worst = 0;
  for (const StageSpec& stage :
       {StageSpec{.wave_px = 0.58, .wave_lines = 60, .sideways = 0.5}, StageSpec{.jitter_px = 0.4},
        StageSpec{.walk_px = 0.08}, StageSpec{.wobble_px = 3}}) {
    const ScanGeometry geometry(optics, stage, {}, 400, 5);
    const ScanWindow window{.x_px = 3, .y_px = 11, .width_px = 12, .n_lines = 60};
    std::vector<float> light(12 * 60 * kChannels);
    ScanRenderer(make_function_film(sinusoid(kG, kF)), optics, window, geometry)
        .transmittance(0, 60, light);
    const double f2 = kF * kF + kG * kG;
    const double t = std::exp(-2 * kPi * kPi * 0.36 * f2) * sinc_pi(kF) * sinc_pi(kG);
    for (int y = 0; y < 60; ++y) {
      for (int x = 0; x < 12; ++x) {
        const ScanPlace at = geometry.place(2, x + 3, y + 11);
        const double expected = 0.5 + 0.5 * t * std::cos(2 * kPi * (kG * at.x + kF * at.y));
        const double value = light[static_cast<std::size_t>((y * kChannels + 2) * 12 + x)];
        worst = std::max(worst, std::abs(value - expected));
      }
    }
  }
  std::printf("displaced lines of a sinusoid: largest error %.1e of bare light\n", worst);
  EXPECT_LT(worst, 3e-5);
}

TEST(Motion, DistortionAndLateralColourMoveEachChannelAsTheGeometrySays) {
  constexpr double kF = 0.17;
  OpticsSpec optics;
  optics.blur_px.fill(0.6);
  optics.distortion = -0.006;
  optics.stretch_px = {0.8, 0, -0.5, 1.7};
  optics.shift_x_px = {0.2, 0, -0.1, 0.35};
  optics.shift_y_px = {0.25, 0, 0.5, -0.25};
  const ScanGeometry geometry(optics, {}, {}, 2000, 1);
  double worst = 0;
  for (const int x0 : {0, 500, 990, 1960}) {
    const ScanWindow window{.x_px = x0, .y_px = 7, .width_px = 40, .n_lines = 2};
    std::vector<float> light(40 * 2 * kChannels);
    ScanRenderer(make_function_film(sinusoid(kF, 0.1)), optics, window, geometry)
        .transmittance(0, 2, light);
    const double t =
        std::exp(-2 * kPi * kPi * 0.36 * (kF * kF + 0.01)) * sinc_pi(kF) * sinc_pi(0.1);
    for (int y = 0; y < 2; ++y) {
      for (int c = 0; c < kChannels; ++c) {
        for (int x = 0; x < 40; ++x) {
          const ScanPlace at = geometry.place(c, x + x0, y + 7);
          const double expected = 0.5 + 0.5 * t * std::cos(2 * kPi * (kF * at.x + 0.1 * at.y));
          const double value = light[static_cast<std::size_t>((y * kChannels + c) * 40 + x)];
          worst = std::max(worst, std::abs(value - expected));
        }
      }
    }
  }
  std::printf("distortion and lateral colour: largest error %.1e of bare light\n", worst);
  EXPECT_LT(worst, 3e-5);
  // At the end of the field: half the field times the distortion, and the stretch.
  const double end = 999.5 + 1000;
  EXPECT_NEAR(geometry.place(1, end, 0).x - end, -6, 1e-9);
  EXPECT_NEAR(geometry.place(3, end, 0).x - geometry.place(1, end, 0).x, 2.05, 1e-9);
  EXPECT_EQ(geometry.place(999.5, 0).x, 999.5);
}

TEST(Motion, PlacesOfTwoAndThreeLineSensors) {
  SensorSpec two;
  two.n_lines = 2;
  SensorSpec three;
  three.n_lines = 3;
  three.line_gap_px = 12;
  for (int y = -40; y < 80; ++y) {
    const SensorLine a = sensor_line(y, two);
    EXPECT_EQ(a.index, ((y % 2) + 2) % 2) << y;
    EXPECT_EQ(a.stage_y, y - a.index);
    // A block is 36 lines: position p of the stage exposes lines p, p + 12 and p + 24.
    const int in_block = ((y % 36) + 36) % 36;
    const SensorLine b = sensor_line(y, three);
    EXPECT_EQ(b.index, in_block / 12) << y;
    EXPECT_EQ(b.stage_y, y - 12 * b.index);
  }
  // Lines exposed together share the stage's error; stagger comes on top.
  three.stagger_y_px = 0.1;
  three.stagger_x_px = -0.2;
  const ScanGeometry geometry({}, {.jitter_px = 0.3}, three, 100, 9);
  for (int p = 0; p < 12; ++p) {
    const double e = geometry.line_error(p).y;
    EXPECT_NEAR(geometry.line_error(p + 12).y, e + 0.1, 1e-12);
    EXPECT_NEAR(geometry.line_error(p + 24).y, e + 0.2, 1e-12);
    EXPECT_NEAR(geometry.line_error(p + 24).x, -0.4, 1e-12);
  }
}

class AnyScanner : public testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(
    Optics, AnyScanner,
    testing::Values("optics=coolscan&focus_curve_um=80&halo=0.05&flare=0.01&distortion=-0.006",
                    "wave_px=0.6&wave_lines=60&jitter_px=0.2&walk_px=0.01&sensor_lines=3&"
                    "line_gap_px=12&line_response=1&stagger_px=0.2&dark=0.01&pixel_gain=0.01"));

// Same seed, same bytes: for any number of threads and any cutting into calls.
TEST_P(AnyScanner, DoesNotDependOnThreadsOrCuts) {
  const SimSpec spec =
      parse_sim_spec(std::string("ls5000?width_px=300&height_px=400&scene=natural&") + GetParam());
  const ScanWindow window{.x_px = 20, .y_px = 30, .width_px = 70, .n_lines = 150};
  std::vector<std::uint16_t> one, three;
  with_threads(1, [&] { one = simulate_window(spec, window).samples; });
  with_threads(3, [&] { three = simulate_window(spec, window).samples; });
  EXPECT_EQ(one, three);

  const ScanRenderer renderer(make_film(spec.film), spec.optics, window,
                              geometry_of(spec, spec.sensor));
  const std::size_t per_line = 70 * kChannels;
  std::vector<float> whole(per_line * 150), parts(whole.size());
  renderer.transmittance(0, 150, whole);
  for (int last = 150, n = 5; last > 0; n = n * 3 % 31 + 1) {
    const int first = std::max(0, last - n);
    const std::size_t size = per_line * static_cast<std::size_t>(last - first);
    renderer.transmittance(
        first, last - first,
        std::span(parts).subspan(per_line * static_cast<std::size_t>(first), size));
    last = first;
  }
  EXPECT_EQ(whole, parts);
}

TEST_P(AnyScanner, RenderingIsConvergedByItsOwnEstimate) {
  const SimSpec spec =
      parse_sim_spec(std::string("ls5000?width_px=300&height_px=400&") + GetParam());
  const ScanWindow window{.width_px = 300, .n_lines = 400};
  const RenderError e =
      estimate_error(make_film(spec.film), spec.optics, window, geometry_of(spec, spec.sensor), 6);
  std::printf("%s: %d cells, rms %.1e, largest %.1e\n", GetParam(), e.cells_per_px, e.rms,
              e.largest);
  EXPECT_LT(e.rms, 5e-5);
  EXPECT_LT(e.largest, 3e-4);
}

// Bare light stays bare light, darkness dark, whatever the optics.
TEST_P(AnyScanner, AnEvenFilmStaysEven) {
  SimSpec spec = parse_sim_spec(std::string("ls5000?width_px=300&height_px=400&") + GetParam());
  const auto film = make_function_film([](double, double, double) { return 0.25; }, 30);
  const ScanWindow window{.x_px = 100, .y_px = 100, .width_px = 40, .n_lines = 6};
  std::vector<float> light(40 * 6 * kChannels);
  ScanRenderer(film, spec.optics, window, geometry_of(spec, spec.sensor))
      .transmittance(0, 6, light);
  for (const float v : light) ASSERT_NEAR(v, 0.25, 2e-6);
}

TEST(Focus, HeightOfTheFilmAndFieldCurvatureSoftenTheImage) {
  OpticsSpec optics;
  optics.f_number.fill(8);
  optics.blur_px.fill(0.1);
  constexpr double kF = 0.3;
  const auto contrast = [&](const OpticsSpec& o, double height_um, int x_px) {
    const ScanWindow window{.x_px = x_px, .width_px = 40, .n_lines = 1};
    std::vector<float> light(40 * kChannels);
    ScanRenderer(make_function_film(sinusoid(kF, 0), height_um), o, window,
                 ScanGeometry(o, {}, {}, 2000, 1))
        .transmittance(0, 1, light);
    const auto [low, high] = std::minmax_element(light.begin(), light.begin() + 40);
    return static_cast<double>(*high - *low);
  };
  const double s = kF * 0.64 * 8 / optics.pixel_um;
  const double gauss = std::exp(-2 * kPi * kPi * 0.01 * kF * kF) * sinc_pi(kF);
  for (const double z : {0.0, 40.0, 90.0}) {
    const double exact = lens(s, z / (8 * 64 * 0.64)) * gauss;
    EXPECT_NEAR(contrast(optics, z, 980), exact, 3e-3) << z;
    EXPECT_NEAR(contrast(optics, -z, 980), exact, 3e-3) << "both sides of focus";
  }
  OpticsSpec curved = optics;
  curved.focus_curvature_um = 90;
  EXPECT_NEAR(contrast(curved, 0, 980), contrast(optics, 0, 980), 3e-3);
  EXPECT_NEAR(contrast(curved, 0, 1960), contrast(optics, 90 * 0.98 * 0.98, 980), 6e-3);
  EXPECT_NEAR(contrast(curved, -90 * 0.98 * 0.98, 1960), contrast(optics, 0, 980), 6e-3);
}

TEST(Flare, SpreadsItsShareOverTheSlit) {
  OpticsSpec optics;
  optics.flare = 0.04;
  // Half of the field is clear.
  const auto film = make_function_film(edge(0, 200));
  const ScanWindow window{.x_px = 20, .y_px = 0, .width_px = 20, .n_lines = 2};
  std::vector<float> light(20 * 2 * kChannels);
  ScanRenderer(film, optics, window, ScanGeometry(optics, {}, {}, 400, 1))
      .transmittance(0, 2, light);
  for (const float v : light) EXPECT_NEAR(v, 0.04 * 0.5, 2e-4);
}

}  // namespace
}  // namespace reseau::sim
