// Settings of the lens by their names: each does what its unit says, and only to its channel.
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "drivers/sim/scan_renderer.h"
#include "drivers/sim/simulate.h"
#include "tests/unit/sim/test_films.h"

namespace reseau::sim {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kField = 2000, kSpan = 40;

// Amplitude and phase [px] of a sinusoid along x (or y) as a channel shows it, about a place.
struct Seen {
  double contrast = 0, shift_px = 0;
};
Seen look(const std::string& settings, int channel, double f, bool along_y = false,
          int x_px = kField / 2 - kSpan / 2, int y_px = 0) {
  const SimSpec spec = parse_sim_spec("ls5000?width_px=" + std::to_string(kField) + "&" + settings);
  const ScanWindow window{.x_px = x_px, .y_px = y_px, .width_px = kSpan, .n_lines = kSpan};
  std::vector<float> light(static_cast<std::size_t>(kSpan * kSpan * kChannels));
  ScanRenderer(make_function_film(along_y ? sinusoid(0, f) : sinusoid(f, 0)), spec.optics, window,
               geometry_of(spec, spec.sensor))
      .transmittance(0, kSpan, light);
  std::complex<double> sum = 0;
  for (int i = 0; i < kSpan; ++i) {
    const int y = along_y ? i : 0, x = along_y ? 0 : i;
    const double place = along_y ? y_px + y : x_px + x;
    const float v = light[static_cast<std::size_t>((y * kChannels + channel) * kSpan + x)];
    sum += (static_cast<double>(v) - 0.5) * std::polar(1.0, -2 * kPi * f * place);
  }
  return {4 * std::abs(sum) / kSpan, std::arg(sum) / (2 * kPi * f)};
}

// 0.3 cycles/px make whole cycles of the span.
constexpr double kF = 0.3;
double expected(int channel, double z_um, double f_number = 8) {
  const double wavelength = std::array{0.64, 0.53, 0.46, 0.87}[static_cast<std::size_t>(channel)];
  const double s = kF * wavelength * f_number / 6.35;
  return lens(s, z_um / (8 * f_number * f_number * wavelength)) * sinc_pi(kF);
}

TEST(OpticsKeys, FocusOfAChannelAPlaceAndALine) {
  const std::string sharp = "f_number=8&blur_px=0&ir_blur_px=0&";
  for (int c = 0; c < 4; ++c) EXPECT_NEAR(look(sharp, c, kF).contrast, expected(c, 0), 3e-3);
  EXPECT_NEAR(look(sharp + "focus_um=70", 1, kF).contrast, expected(1, 70), 3e-3);
  const std::string split = sharp + "blue_focus_um=60&ir_focus_um=-80";
  EXPECT_NEAR(look(split, 2, kF).contrast, expected(2, 60), 3e-3);
  EXPECT_NEAR(look(split, 3, kF).contrast, expected(3, 80), 3e-3);
  EXPECT_NEAR(look(split, 0, kF).contrast, expected(0, 0), 3e-3) << "red is left alone";
  // The tilt reaches its value at the field's end and the other sign at the other.
  const std::string tilt = sharp + "focus_um=20&focus_tilt_um=60";
  const double rho = (kField - kSpan / 2.0 - 0.5 - (kField - 1) / 2.0) / (kField / 2.0);
  EXPECT_NEAR(look(tilt, 0, kF, false, kField - kSpan).contrast, expected(0, 20 + 60 * rho), 3e-3);
  EXPECT_NEAR(look(tilt, 0, kF, false, 0).contrast, expected(0, 20 - 60 * rho), 3e-3);
  EXPECT_NEAR(look(sharp + "focus_drift_um=50", 0, kF, false, 980, 1600).contrast,
              expected(0, 50 * 1.6), 3e-3);
  EXPECT_NEAR(look("f_number=8&ir_f_number=5&blur_px=0&ir_blur_px=0", 3, kF).contrast,
              expected(3, 0, 5), 3e-3);
  // Another wavelength, another cutoff.
  const double s = kF * 0.7 * 8 / 6.35;
  EXPECT_NEAR(look(sharp + "red_nm=700", 0, kF).contrast, lens(s, 0) * sinc_pi(kF), 3e-3);
}

TEST(OpticsKeys, AstigmatismPartsTheFoci) {
  // Vertical bars are in focus half of it on one side, horizontal ones on the other.
  const std::string settings = "f_number=8&blur_px=0&astigmatism_um=80&focus_um=";
  for (const double z : {40.0, -40.0}) {
    const double along_x = look(settings + std::to_string(z), 0, kF).contrast;
    const double along_y = look(settings + std::to_string(z), 0, kF, true).contrast;
    const double sharp = std::max(along_x, along_y), soft = std::min(along_x, along_y);
    EXPECT_EQ(along_x<along_y, z> 0) << "focus along the sensor is +40 from best focus";
    EXPECT_NEAR(sharp, expected(0, 0), 0.02);
    EXPECT_LT(soft, 0.9 * sharp);
  }
}

TEST(OpticsKeys, ShiftsAndStretchesMoveTheirChannel) {
  const std::string settings =
      "red_shift_px=0.3&blue_shift_px=-0.4&ir_shift_px=0.2&red_shift_y_px=-0.25&"
      "blue_shift_y_px=0.15&ir_shift_y_px=0.35";
  const double x[] = {0.3, 0, -0.4, 0.2}, y[] = {-0.25, 0, 0.15, 0.35};
  for (int c = 0; c < 4; ++c) {
    EXPECT_NEAR(look(settings, c, kF).shift_px, x[c], 2e-3) << c;
    EXPECT_NEAR(look(settings, c, kF, true).shift_px, y[c], 2e-3) << c;
  }
  // A stretch displaces in proportion to the distance from the axis.
  const std::string stretch = "red_stretch_px=0.5&blue_stretch_px=-0.6&ir_stretch_px=0.4";
  const double at_end[] = {0.5, 0, -0.6, 0.4};
  for (const int left : {0, 500, kField - kSpan}) {
    const double rho = (left + kSpan / 2.0 - 0.5 - (kField - 1) / 2.0) / (kField / 2.0);
    for (int c = 0; c < 4; ++c) {
      EXPECT_NEAR(look(stretch, c, kF, false, left).shift_px, at_end[c] * rho, 4e-3) << c;
    }
  }
}

TEST(OpticsKeys, WaveHasItsPhaseAndShareSideways) {
  const SimSpec spec =
      parse_sim_spec("ls5000?wave_px=0.5&wave_lines=200&wave_phase=90&wave_sideways=-0.2");
  const ScanGeometry geometry = geometry_of(spec, spec.sensor);
  EXPECT_NEAR(geometry.place(10, 0).y, 0.5, 1e-12);
  EXPECT_NEAR(geometry.place(10, 0).x, 10 - 0.1, 1e-12);
  EXPECT_NEAR(geometry.place(10, 100).y, 99.5, 1e-12);
}

}  // namespace
}  // namespace reseau::sim
