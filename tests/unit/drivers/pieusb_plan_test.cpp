#include <cstdlib>
#include <fstream>
#include <limits>
#include <random>
#include <sstream>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "drivers/pieusb/metering_pass.h"
#include "drivers/pieusb/plan.h"
#include "tests/unit/drivers/pieusb_units.h"

namespace reseau::pieusb {
namespace {

UnitDescription rps() { return pie_unit(0x31, 7200, 10344, 6888); }

TEST(PiePlan, TheDefaultIsTheWholeFrameAtTheNativeResolutionWithInfrared) {
  const Negotiated n = negotiate({}, rps());
  EXPECT_TRUE(n.adjusted.empty());
  EXPECT_EQ(n.plan.resolution_dpi, 3600);
  EXPECT_EQ(n.plan.format.width_px, 5172);
  EXPECT_EQ(n.plan.format.n_lines, 3444);
  EXPECT_EQ(n.plan.format.n_channels(), 4);
  EXPECT_EQ(n.plan.depth_bits, 16);
  EXPECT_EQ(frame_of(n.plan, rps()), (ScanFrame{0, 0, 10343, 6887}));
}

TEST(PiePlan, RoundsToTheNextFinerDivisorAndSaysSo) {
  ScanRequest request;
  request.resolution_dpi = 1000;
  const Negotiated n = negotiate(request, rps());
  EXPECT_EQ(7200 % n.plan.resolution_dpi, 0);
  EXPECT_GE(n.plan.resolution_dpi, 1000);
  EXPECT_EQ(n.plan.resolution_dpi, 1200);
  ASSERT_EQ(n.adjusted.size(), 1U);
  EXPECT_EQ(n.adjusted[0].granted, "1200 dpi");
}

TEST(PiePlan, AFocusPositionIsNotTakenSilently) {
  ScanRequest request;
  request.focus.mode = FocusRequest::Mode::kPosition;
  request.focus.position = 100;
  const Negotiated n = negotiate(request, rps());
  ASSERT_EQ(n.adjusted.size(), 1U);
  EXPECT_EQ(n.adjusted[0].field, "focus");
  EXPECT_EQ(n.plan.focus.mode, FocusRequest::Mode::kKeep);
}

TEST(PiePlan, WhatOtherFamiliesCanIsNotTakenSilently) {
  ScanRequest request;
  request.samples = 4;
  request.frame_offset_mm = 1.5;
  request.sensor_lines = SensorLines::kAll;
  EXPECT_EQ(negotiate(request, rps()).adjusted.size(), 3U);
  request.overview = true;
  EXPECT_THROW((void)negotiate(request, rps()), InputError);
}

TEST(PiePlan, NeverLeavesTheScanArea) {
  std::mt19937 random(20261124);
  std::uniform_real_distribution<double> mm(-20, 60);
  for (const UnitDescription& unit : pie_units()) {
    for (int round = 0; round < 1000; ++round) {
      ScanRequest request;
      request.resolution_dpi = static_cast<int>(random() % 8000) + 1;
      request.area = {mm(random), mm(random), std::abs(mm(random)) + 0.1,
                      std::abs(mm(random)) + 0.1};
      Negotiated n;
      try {
        n = negotiate(request, unit);
      } catch (const InputError&) {
        EXPECT_TRUE(*request.area.left_mm > 20 || *request.area.top_mm > 20);
        continue;
      }
      const ScanFrame f = frame_of(n.plan, unit);
      ASSERT_TRUE(f.x0 >= 0 && f.y0 >= 0 && f.x0 <= f.x1 && f.y0 <= f.y1);
      ASSERT_LT(f.x1, unit.inquiry.max_width_px);
      ASSERT_LT(f.y1, unit.inquiry.max_height_px);
      ASSERT_EQ((f.x1 - f.x0 + 1) / n.plan.pitch, n.plan.format.width_px);
      ASSERT_EQ((f.y1 - f.y0 + 1) / n.plan.pitch, n.plan.format.n_lines);
      for (const PassSpec& pass : {coarse_pass_of(n.plan, unit),
                                   fine_pass_of(n.plan, unit, coarse_pass_of(n.plan, unit), 0)
                                       .value_or(pass_of(n.plan, unit))}) {
        const int pitch = unit.inquiry.max_dpi / pass.dpi;
        ASSERT_TRUE(pass.frame.x0 >= f.x0 && pass.frame.x1 <= f.x1);
        ASSERT_TRUE(pass.frame.y0 >= f.y0 && pass.frame.y1 <= f.y1);
        ASSERT_EQ((pass.frame.x1 - pass.frame.x0 + 1) / pitch, pass.width_px);
        ASSERT_EQ((pass.frame.y1 - pass.frame.y0 + 1) / pitch, pass.n_lines);
      }
    }
  }
}

TEST(PiePlan, NegotiatingAPlanAgainAdjustsNothing) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> mm(0, 20);
  const UnitDescription unit = rps();
  const auto to_mm = [](int px) { return px * 25.4 / 7200; };
  for (int round = 0; round < 500; ++round) {
    ScanRequest request;
    request.resolution_dpi = static_cast<int>(random() % 7200) + 1;
    request.area = {mm(random), mm(random), 0.1 + mm(random), 0.1 + mm(random)};
    const ScanPlan first = negotiate(request, unit).plan;
    request.resolution_dpi = first.resolution_dpi;
    request.area = {to_mm(first.x_origin_px), to_mm(first.y_origin_px),
                    to_mm(first.window_width_px), to_mm(first.window_height_px)};
    const Negotiated again = negotiate(request, unit);
    ASSERT_TRUE(again.adjusted.empty());
    ASSERT_EQ(again.plan.format, first.format);
    ASSERT_EQ(again.plan.describe(), first.describe());
  }
}

TEST(PiePlan, RefusesWhatCannotBeMeant) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [&](auto change) {
    ScanRequest request;
    change(request);
    EXPECT_THROW((void)negotiate(request, rps()), InputError);
  };
  refused([](ScanRequest& r) { r.resolution_dpi = 0; });
  refused([](ScanRequest& r) { r.frame = 0; });
  refused([](ScanRequest& r) { r.frame = 7; });
  refused([](ScanRequest& r) { r.area.width_mm = 0; });
  refused([&](ScanRequest& r) { r.area.left_mm = nan; });
  refused([&](ScanRequest& r) { r.exposure.factor = nan; });
  refused([](ScanRequest& r) {
    r.exposure.mode = ExposureRequest::Mode::kFixed;
    r.exposure.exposure_us[3] = -1;
  });
  ScanRequest second;
  second.frame = 2;
  EXPECT_THROW((void)negotiate(second, pie_unit(0x2E, 3600, 5172, 3444)), InputError);
}

TEST(PiePlan, ExposuresStayBelowWhereTheTimerWraps) {
  ScanRequest request;
  request.exposure.mode = ExposureRequest::Mode::kFixed;
  request.exposure.exposure_us[0] = 1e6;
  const Negotiated n = negotiate(request, rps());
  ASSERT_EQ(n.adjusted.size(), 1U);
  EXPECT_NEAR(*n.plan.exposure.exposure_us[0], 65535 * kExposureStepUs, 1e-9);
}

std::string all_pie_plans() {
  std::ostringstream text;
  for (const UnitDescription& unit : pie_units()) {
    const Capabilities c = capabilities_of(unit);
    for (const int dpi : c.resolutions_dpi) {
      for (const int bits : c.depths_bits) {
        for (const bool infrared : {false, true}) {
          ScanRequest request;
          request.resolution_dpi = dpi;
          request.depth_bits = bits;
          request.infrared = infrared;
          const ScanPlan plan = negotiate(request, unit).plan;
          const ScanFrame f = frame_of(plan, unit);
          text << c.model << ", " << dpi << " dpi, " << bits << " bits, "
               << (infrared ? "RGBI" : "RGB") << ": pitch " << plan.pitch << ", frame " << f.x0
               << " " << f.y0 << " " << f.x1 << " " << f.y1 << ", " << plan.format.n_lines
               << " rows of " << plan.format.width_px << " px, " << plan.format.n_channels()
               << " channels, " << plan.format.significant_bits << " bits, " << plan.format.x_dpi
               << " x " << plan.format.y_dpi << " dpi; mode "
               << hex_of(mode_data({plan.resolution_dpi, plan.infrared, plan.depth_bits, 0x0008}))
               << "\n";
        }
      }
    }
  }
  return text.str();
}

TEST(PiePlan, EveryResolutionDepthAndChannelSetIsAsItWas) {
  const std::string plans = all_pie_plans();
  // The new text is always in the build tree, to be looked at and copied when a change is meant.
  std::ofstream(RESEAU_PIE_GOLDEN_OUT) << plans;
  std::ifstream file(RESEAU_GOLDEN_DIR "/pieusb_plans.txt");
  std::stringstream golden;
  golden << file.rdbuf();
  EXPECT_TRUE(golden.str() == plans)
      << "differs from pieusb_plans.txt; compare with " RESEAU_PIE_GOLDEN_OUT;
}

}  // namespace
}  // namespace reseau::pieusb
