// Every simulated model, mode and adapter through the driver, against the film itself.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "drivers/sim/simulate.h"
#include "tests/replay/simulated_scan.h"

namespace reseau {
namespace {

constexpr const char* kModels[] = {"ls5000", "ls50",   "ls40",   "ls4000",
                                   "ls8000", "ls9000", "ls2000", "ls30"};

ScanRequest corner(int dpi) {
  ScanRequest request;
  request.resolution_dpi = dpi;
  request.area = {3.0, 4.0, 2.5, 1.2};
  request.exposure.mode = ExposureRequest::Mode::kFixed;
  request.focus.mode = FocusRequest::Mode::kPosition;
  request.focus.position = 209;  // where the simulated units are sharp
  return request;
}

std::string quiet(const std::string& model) { return "sim:" + model + "?noise=0"; }

// Largest difference to what the film, the optics and the converter give at that place.
int largest_error(const std::string& name, const ScanRequest& request, const Outcome& outcome,
                  int left_px, int top_px) {
  sim::SimSpec spec = sim::parse_sim_spec(name);
  const int pitch = static_cast<int>(std::lround(
      outcome.format.x_dpi > 0 ? 25400.0 / spec.film.frame.pixel_um / outcome.format.x_dpi : 1));
  sim::ScanWindow window;
  window.pitch = pitch;
  window.x_px = left_px;
  window.y_px = top_px;
  window.width_px = outcome.format.width_px;
  window.n_lines = outcome.format.n_lines;
  spec.sensor.adc_bits = 16;
  const sim::SimulatedScan truth = sim::simulate_window(spec, window);
  int largest = 0;
  const auto n_channels = static_cast<std::size_t>(outcome.format.n_channels());
  const auto width = static_cast<std::size_t>(window.width_px);
  for (std::size_t line = 0; line < static_cast<std::size_t>(window.n_lines); ++line) {
    for (std::size_t c = 0; c < n_channels; ++c) {
      for (std::size_t x = 0; x < width; ++x) {
        const int got = outcome.samples[(line * n_channels + c) * width + x];
        const int expected = truth.samples[(line * 4 + c) * width + x];
        largest = std::max(largest, std::abs(got - expected));
      }
    }
  }
  (void)request;
  return largest;
}

struct Case {
  std::string model;
  int dpi, depth, samples;
  SensorLines lines;
  bool infrared;
  int tolerance;  // steps of 65535, from the depth of the wire
};

class EveryModel : public testing::TestWithParam<Case> {};

TEST_P(EveryModel, DeliversTheFilm) {
  const Case& c = GetParam();
  const std::string name = quiet(c.model);
  const auto scanner = open_any(name);
  ScanRequest request = corner(c.dpi);
  request.depth_bits = c.depth;
  request.samples = c.samples;
  request.sensor_lines = c.lines;
  request.infrared = c.infrared;
  const Negotiated negotiated = scanner->negotiate(request);
  ASSERT_EQ(negotiated.plan.samples, c.samples);
  if (c.lines == SensorLines::kAll) {
    ASSERT_GT(negotiated.plan.sensor_lines, 1);
  }
  const Outcome outcome = scan_of(*scanner, request);
  ASSERT_TRUE(outcome.complete);
  ASSERT_EQ(outcome.samples.size(),
            outcome.format.samples_per_line() * static_cast<std::size_t>(outcome.format.n_lines));
  const ScanPlan& plan = negotiated.plan;
  const int holder_top = c.model == "ls9000" ? 0x08bc : 0;
  EXPECT_LE(largest_error(name, request, outcome, plan.x_origin_px + plan.crop_left_px * plan.pitch,
                          plan.y_origin_px + plan.crop_top_lines * plan.pitch - holder_top),
            c.tolerance);
  // And the unit is free for the next one.
  EXPECT_EQ(scan_of(*scanner, request).samples, outcome.samples);
}

std::vector<Case> cases() {
  const auto k1 = SensorLines::kOne;
  const auto kN = SensorLines::kAll;
  return {
      {"ls5000", 4000, 16, 1, k1, true, 1},   {"ls5000", 4000, 16, 1, kN, true, 4},
      {"ls5000", 4000, 16, 4, kN, true, 4},   {"ls5000", 4000, 16, 3, kN, false, 4},
      {"ls5000", 2000, 16, 2, k1, true, 1},   {"ls50", 4000, 14, 1, k1, true, 3},
      {"ls50", 1333, 8, 1, k1, true, 258},    {"ls40", 2900, 12, 1, k1, true, 17},
      {"ls40", 1450, 8, 1, k1, false, 258},   {"ls4000", 4000, 14, 4, k1, true, 3},
      {"ls4000", 1333, 8, 1, k1, false, 258}, {"ls8000", 4000, 14, 1, kN, true, 3},
      {"ls8000", 2000, 14, 2, kN, true, 3},   {"ls8000", 4000, 14, 1, k1, true, 3},
      {"ls9000", 4000, 16, 1, kN, true, 4},   {"ls9000", 1333, 16, 1, kN, true, 4},
      {"ls9000", 4000, 16, 3, kN, false, 4},  {"ls9000", 1000, 16, 1, k1, true, 1},
      {"ls2000", 2700, 12, 1, k1, true, 17},  {"ls2000", 1350, 8, 1, k1, true, 258},
      {"ls30", 2700, 10, 1, k1, true, 65},
  };
}

std::string case_name(const testing::TestParamInfo<Case>& info) {
  const Case& c = info.param;
  return c.model + "_" + std::to_string(c.dpi) + "_" + std::to_string(c.depth) + "_" +
         std::to_string(c.samples) + (c.lines == SensorLines::kAll ? "_all" : "_one") +
         (c.infrared ? "_rgbi" : "_rgb");
}

INSTANTIATE_TEST_SUITE_P(Modes, EveryModel, testing::ValuesIn(cases()), case_name);

TEST(EveryModel, MetersFocusesAndScans) {
  for (const std::string model : kModels) {
    SCOPED_TRACE(model);
    const auto scanner = open_any("sim:" + model);
    ScanRequest request;
    request.resolution_dpi = scanner->capabilities().optical_dpi / 4;
    request.area = {3.0, 4.0, 2.5, 1.2};
    const Outcome outcome = scan_of(*scanner, request);
    ASSERT_TRUE(outcome.complete);
    const auto brightest = *std::max_element(outcome.samples.begin(), outcome.samples.end());
    EXPECT_GT(brightest, 30000);
    EXPECT_GT(outcome.context.exposure_us[0].value_or(0), 0);
  }
}

TEST(EveryModel, TheLinesOfTheSensorDifferUntilTheyAreCorrected) {
  // Curves that are not applied would show here as banding of hundreds of steps.
  const auto scanner = open_any("sim:ls5000?noise=0");
  ScanRequest request = corner(4000);
  request.sensor_lines = SensorLines::kOne;
  const Outcome one = scan_of(*scanner, request);
  request.sensor_lines = SensorLines::kAll;
  const Outcome two = scan_of(*scanner, request);
  ASSERT_EQ(one.samples.size(), two.samples.size());
  int largest = 0;
  for (std::size_t i = 0; i < one.samples.size(); ++i) {
    largest = std::max(largest, std::abs(one.samples[i] - two.samples[i]));
  }
  EXPECT_LE(largest, 4);
}

TEST(EveryModel, OddLinesBeginAndEndWithSurplusOnes) {
  const auto scanner = open_any("sim:ls5000?noise=0&line_response=0");
  for (const int top_px : {600, 601}) {
    for (const int n_lines : {40, 41}) {
      ScanRequest request = corner(4000);
      request.area.top_mm = top_px * 25.4 / 4000;
      request.area.height_mm = n_lines * 25.4 / 4000;
      request.sensor_lines = SensorLines::kAll;
      const Outcome two = scan_of(*scanner, request);
      request.sensor_lines = SensorLines::kOne;
      const Outcome one = scan_of(*scanner, request);
      EXPECT_TRUE(two.complete);
      EXPECT_EQ(two.format.n_lines, n_lines);
      EXPECT_TRUE(one.samples == two.samples) << top_px << " " << n_lines;
    }
  }
}

TEST(EveryModel, LinksThatDisturbChangeNothing) {
  const ScanRequest request = corner(1000);
  const auto of = [&](const std::string& name) {
    const auto scanner = open_any(name);
    return scan_of(*scanner, request).samples;
  };
  const auto plain = of("sim:ls5000?noise=0");
  ASSERT_FALSE(plain.empty());
  EXPECT_TRUE(of("sim:ls5000?noise=0&full_speed=1") == plain) << "a cable of full speed";
  EXPECT_TRUE(of("sim:ls5000?noise=0&stale=64&fragment=512") == plain);
  ScanRequest small = corner(725);
  const auto ls40 = open_any("sim:ls40?noise=0");
  const auto lossy = open_any("sim:ls40?noise=0&lost_commands=7");
  EXPECT_TRUE(scan_of(*ls40, small).samples == scan_of(*lossy, small).samples)
      << "a busy phase that loses the command";
}

TEST(EveryModel, GarbageForASenseIsSurvived) {
  for (const std::string model : kModels) {
    int n_failed = 0;
    for (int at = 1; at < 60; at += 3) {
      SCOPED_TRACE(model + " " + std::to_string(at));
      try {
        const auto scanner =
            open_any("sim:" + model + "?noise=0&garbage_after=" + std::to_string(at));
        ScanRequest request = corner(500);
        request.infrared = false;
        EXPECT_TRUE(scan_of(*scanner, request).complete);
      } catch (const DeviceError& error) {
        ++n_failed;
        EXPECT_NE(std::string(error.what()), "");
      } catch (const InputError& error) {
        // Noise that reads as "refused": the unit then seems to lack a page.
        ++n_failed;
        EXPECT_NE(std::string(error.what()), "");
      }
    }
    EXPECT_LT(n_failed, 20) << "a command that can be repeated is";
  }
}

TEST(EveryModel, AnLs40ThatIsSentASix) {
  const auto usb = sim::open_simulated_unit("sim:ls40");
  const std::byte six{0x06};
  usb->bulk_out(0x01, {&six, 1}, Duration(1));
  EXPECT_THROW((void)open_coolscan(sim::open_simulated_unit("sim:ls40?silent_after=1")),
               DeviceError);
}

TEST(EveryModel, TheStageNeverMeetsItsStop) {
  // The simulated LS-9000 takes a window beyond the boundary and jams; no request may lead there.
  for (const char* const model : {"sim:ls9000", "sim:ls8000"}) {
    const auto scanner = open_any(std::string(model) + "?noise=0&film=none");
    for (const double top_mm : {0.0, 40.0, 70.0, 83.0, 88.0, 150.0}) {
      for (const double offset_mm : {-40.0, 0.0, 39.0}) {
        ScanRequest request = corner(667);
        request.infrared = false;
        request.area = {1.0, top_mm, 0.3, 90.0};
        request.frame_offset_mm = offset_mm;
        try {
          const ScanPlan plan = scanner->negotiate(request).plan;
          KeepingObserver observer;
          ASSERT_TRUE(scanner->start(plan, observer, {}));
          LineBlock block;
          ASSERT_EQ(scanner->read(block, Duration(0)), ReadStatus::kLines);
          scanner->stop();
        } catch (const InputError&) {
          continue;  // nothing of the frame lies there
        }
      }
    }
    EXPECT_TRUE(scan_of(*scanner, corner(667)).complete);
  }
}

}  // namespace
}  // namespace reseau
