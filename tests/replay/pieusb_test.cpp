// The PIE driver against simulated units.
#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "drivers/sim/simulate.h"
#include "tests/replay/pie_scan.h"

namespace reseau {
namespace {

ScanRequest fixed_request() {
  ScanRequest request = small_request();
  request.resolution_dpi = 600;
  request.exposure.mode = ExposureRequest::Mode::kFixed;
  return request;
}

TEST(Pieusb, KnowsEveryModelFromItsInquiry) {
  for (const char* const name : kPieUnits) {
    const auto scanner = open_pie(name);
    const Capabilities& c = scanner->capabilities();
    EXPECT_EQ(c.make, "PIE") << name;
    EXPECT_NE(c.model, "") << name;
    EXPECT_EQ(c.depths_bits, (std::vector<int>{8, 16})) << name;
    EXPECT_TRUE(c.infrared) << name;
    EXPECT_TRUE(c.film_present) << name;
  }
  EXPECT_EQ(open_pie("sim:rps7200")->capabilities().optical_dpi, 7200);
  EXPECT_EQ(open_pie("sim:rps7200")->capabilities().n_frames, 6);
  EXPECT_EQ(open_pie("sim:proscan10t")->capabilities().optical_dpi, 10000);
}

TEST(Pieusb, ScansOnEveryModelWithAndWithoutInfraredAtBothDepths) {
  for (const char* const name : kPieUnits) {
    const auto scanner = open_pie(std::string(name) + "?noise=0");
    for (const bool infrared : {true, false}) {
      for (const int bits : {8, 16}) {
        ScanRequest request = fixed_request();
        request.infrared = infrared;
        request.depth_bits = bits;
        const Outcome outcome = scan_of(*scanner, request);
        EXPECT_TRUE(outcome.complete) << name;
        EXPECT_EQ(outcome.samples.size(), static_cast<std::size_t>(outcome.format.width_px) *
                                              static_cast<std::size_t>(outcome.format.n_lines) *
                                              (infrared ? 4U : 3U))
            << name;
        EXPECT_EQ(outcome.context.exposure_us[3].has_value(), infrared);
      }
    }
  }
}

TEST(Pieusb, TheSamplesAreTheFilms) {
  // The same window of the same film without a unit: the driver's rows are that, evened out.
  const std::string film = "?noise=0&scene=chart&blur_px=1";
  for (const std::string name : {"sim:crystalscan3600", "sim:rps7200"}) {
    const auto scanner = open_pie(name + film);
    ScanRequest request = fixed_request();
    request.infrared = false;
    const ScanPlan plan = scanner->negotiate(request).plan;
    const Outcome outcome = scan_of(*scanner, request);
    ASSERT_TRUE(outcome.complete);
    sim::SimSpec spec = sim::parse_sim_spec(name + film);
    spec.sensor.shading = spec.sensor.pixel_gain = spec.sensor.dark_level = 0;
    spec.sensor.dark_pattern = 0;
    const sim::ScanWindow window{plan.x_origin_px, plan.y_origin_px, plan.format.width_px,
                                 plan.format.n_lines, plan.pitch};
    const sim::SimulatedScan truth = sim::simulate_window(spec, window);
    const int width = plan.format.width_px;
    // One factor per colour: what the mean pixel of the sensor makes of light.
    double worst = 0;
    for (int c = 0; c < 3; ++c) {
      double sum_truth = 0, sum_scan = 0;
      const auto at = [&](int line, int channels, int x) {
        return static_cast<std::size_t>((line * channels + c) * width + x);
      };
      for (int line = 0; line < plan.format.n_lines; ++line) {
        for (int x = 0; x < width; ++x) {
          sum_truth += truth.samples[at(line, 4, x)];
          sum_scan += outcome.samples[at(line, 3, x)];
        }
      }
      const double factor = sum_scan / sum_truth;
      EXPECT_GT(factor, 0.8) << name;
      EXPECT_LT(factor, 1.1) << name;
      for (int line = 0; line < plan.format.n_lines; ++line) {
        for (int x = 0; x < width; ++x) {
          const double difference =
              outcome.samples[at(line, 3, x)] - (factor * truth.samples[at(line, 4, x)]);
          worst = std::max(worst, std::abs(difference));
        }
      }
    }
    // Without dark lines the dark level of 170 stays, times the gain of the darkest column.
    EXPECT_LT(worst, name == "sim:rps7200" ? 40 : 300) << name;
  }
}

TEST(Pieusb, ShadingTakesAwayLightAndPixelsOfTheSensor) {
  // Bare light, uneven by 30 % and 2 % from pixel to pixel.
  const std::string light = "?noise=0&film=none&shading=0.3&dark=0.0026&outside_px=0&level=0.7";
  for (const char* const name : {"sim:rps7200", "sim:crystalscan3600"}) {
    const auto even = open_pie(std::string(name) + light);
    ScanRequest request = fixed_request();
    request.area = {};
    request.resolution_dpi = 300;
    request.infrared = false;
    const Outcome outcome = scan_of(*even, request);
    ASSERT_TRUE(outcome.complete);
    // Columns of a strip: the spread along the sensor is that of the scene alone.
    EXPECT_GT(*std::max_element(outcome.samples.begin(), outcome.samples.end()), 30000) << name;
  }
}

TEST(Pieusb, RowsOfAPassThatComesBackAreTurnedRound) {
  for (const char* const name : {"sim:rps7200?noise=0", "sim:crystalscan3600?noise=0"}) {
    for (const bool infrared : {false, true}) {
      ScanRequest request = fixed_request();
      request.infrared = infrared;
      const Outcome down = scan_of(*open_pie(name), request);
      const Outcome up = scan_of(*open_pie(std::string(name) + "&bottom_up=1"), request);
      ASSERT_TRUE(down.complete);
      EXPECT_TRUE(up.samples == down.samples) << name;
    }
  }
}

TEST(Pieusb, MetersSoThatNoElementOfTheScreenIsCutOff) {
  for (const char* const name : {"sim:crystalscan3600", "sim:rps7200"}) {
    const auto scanner = open_pie(name);
    ScanRequest request;
    request.resolution_dpi = 3600;
    request.area = {10.0, 10.0, 4.0, 3.0};
    const Outcome outcome = scan_of(*scanner, request);
    ASSERT_TRUE(outcome.complete);
    const auto n_full = std::count(outcome.samples.begin(), outcome.samples.end(), 65535);
    EXPECT_LT(static_cast<double>(n_full), 2e-4 * static_cast<double>(outcome.samples.size()))
        << name;
    EXPECT_GT(*std::max_element(outcome.samples.begin(), outcome.samples.end()), 48000) << name;
  }
}

TEST(Pieusb, MetersEachChannelAloneWhereTheBalanceIsNotLocked) {
  ScanRequest request = small_request();
  const auto exposures = [&](bool lock) {
    request.exposure.lock = lock;
    return scan_of(*open_pie("sim:crystalscan3600?noise=0"), request).context.exposure_us;
  };
  const auto locked = exposures(true), alone = exposures(false);
  // The references of this unit's colours are equal.
  EXPECT_NEAR(*locked[0], *locked[2], 0.02 * *locked[0]);
  EXPECT_GT(std::abs(*alone[0] - *alone[2]), 0.05 * *alone[0]);
}

TEST(Pieusb, WaitsForAColdLampAndASlowUnit) {
  for (const char* const name : kPieUnits) {
    const auto scanner = open_pie(std::string(name) + "?cold=1&busy_polls=7&busy_phases=5&again=3");
    EXPECT_TRUE(scan_of(*scanner, fixed_request()).complete) << name;
  }
}

TEST(Pieusb, AnyFragmentsOfTheBulkDataWillDo) {
  const Outcome whole = scan_of(*open_pie("sim:rps7200?noise=0"), fixed_request());
  const Outcome pieces = scan_of(*open_pie("sim:rps7200?noise=0&fragment=512"), fixed_request());
  ASSERT_TRUE(pieces.complete);
  EXPECT_TRUE(pieces.samples == whole.samples);
}

TEST(Pieusb, AMissingFilmIsSaidWhereTheUnitKnows) {
  const auto scanner = open_pie("sim:rps7200?film=empty");
  EXPECT_FALSE(scanner->capabilities().film_present);
  KeepingObserver observer;
  try {
    (void)scanner->start(scanner->negotiate(small_request()).plan, observer, {});
    FAIL();
  } catch (const DeviceError& error) {
    EXPECT_EQ(error.kind(), DeviceError::Kind::kNoMedium);
  }
}

TEST(Pieusb, MovesAStripToItsFrames) {
  const auto scanner = open_pie("sim:rps7200?noise=0&frames=3&scene=natural");
  ScanRequest request = fixed_request();
  const Outcome first = scan_of(*scanner, request);
  request.frame = 3;
  const Outcome third = scan_of(*scanner, request);
  request.frame = 1;
  const Outcome again = scan_of(*scanner, request);
  EXPECT_TRUE(first.complete && third.complete && again.complete);
  EXPECT_FALSE(third.samples == first.samples);
  EXPECT_TRUE(again.samples == first.samples);
}

TEST(Pieusb, StopInsideAPassReadsItToTheEndAndSaysSo) {
  for (const char* const name : kPieUnits) {
    const auto scanner = open_pie(std::string(name) + "?noise=0");
    ScanRequest request = fixed_request();
    request.area.height_mm = 12.0;
    KeepingObserver observer;
    EXPECT_EQ(scanner->stop_notice(), "");
    ASSERT_TRUE(scanner->start(scanner->negotiate(request).plan, observer, {}));
    LineBlock block;
    ASSERT_EQ(scanner->read(block, Duration(0)), ReadStatus::kLines);
    EXPECT_NE(scanner->stop_notice(), "");
    scanner->stop();
    EXPECT_EQ(scanner->stop_notice(), "");
    scanner->stop();
    EXPECT_EQ(scanner->read(block, Duration(0)), ReadStatus::kEndOfScan);
    EXPECT_TRUE(scan_of(*scanner, request).complete) << name;
  }
}

// Asks to stop when a phase begins.
class StopAtPhase final : public ScanObserver {
 public:
  StopAtPhase(std::string at, std::stop_source& source) : at_(std::move(at)), source_(source) {}
  void phase(ScanPhase, const std::string& detail) override {
    if (detail == at_) source_.request_stop();
  }
  void note(const std::string&) override {}

 private:
  std::string at_;
  std::stop_source& source_;
};

TEST(Pieusb, AStopRequestEndsEveryPhaseWithTheUnitUsable) {
  for (const char* const name : {"sim:crystalscan3600?cold=1", "sim:rps7200?cold=1&frames=2"}) {
    for (const char* const phase : {"waiting for the scanner", "moving to frame 2",
                                    "exposure pass 1", "fine exposure pass 1", "scan"}) {
      const auto scanner = open_pie(name);
      ScanRequest request = small_request();
      request.resolution_dpi = 1200;
      if (scanner->capabilities().n_frames > 1) request.frame = 2;
      std::stop_source source;
      StopAtPhase observer(phase, source);
      const bool started =
          scanner->start(scanner->negotiate(request).plan, observer, source.get_token());
      EXPECT_EQ(started, !source.stop_requested()) << name << " " << phase;
      scanner->stop();
      EXPECT_TRUE(scan_of(*scanner, fixed_request()).complete) << name << " after " << phase;
    }
  }
}

TEST(Pieusb, SaysWhatItDoes) {
  const auto scanner = open_pie("sim:rps7200");
  KeepingObserver observer;
  ASSERT_TRUE(scanner->start(scanner->negotiate(small_request()).plan, observer, {}));
  EXPECT_EQ(observer.phases.back(), "scan");
  ASSERT_FALSE(observer.notes.empty());
  EXPECT_NE(observer.notes.back().find("infrared"), std::string::npos) << observer.notes.back();
  EXPECT_FALSE(scanner->context().focus_position);
  for (const auto& us : scanner->context().exposure_us) EXPECT_GT(us.value_or(0), 0);
}

}  // namespace
}  // namespace reseau
