#include "drivers/coolscan/plan.h"

#include <cstdlib>
#include <fstream>
#include <limits>
#include <random>
#include <sstream>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "tests/unit/drivers/units.h"

namespace reseau::coolscan {
namespace {

TEST(Plan, TheLadderOfAnLs5000IsTheRecordedOne) {
  EXPECT_EQ(capabilities_of(ls5000_mount()).resolutions_dpi,
            (std::vector<int>{4000, 2000, 1000, 666, 500, 400, 333, 285, 250, 222, 200, 181,
                              166,  153,  142,  133, 125, 117, 111, 105, 100, 95,  90}));
}

TEST(Plan, AnLs50TakesEveryDivisor) {
  const std::vector<int> ladder = capabilities_of(ls50_strip()).resolutions_dpi;
  EXPECT_EQ(ladder.size(), 44U);
  EXPECT_EQ(ladder[2], 1333);
}

TEST(Plan, TheDefaultIsTheWholeFrameAtFullResolutionWithInfrared) {
  const Negotiated n = negotiate({}, ls5000_mount());
  EXPECT_TRUE(n.adjusted.empty());
  EXPECT_EQ(n.plan.format.width_px, 3946);
  EXPECT_EQ(n.plan.format.n_lines, 5782);
  EXPECT_EQ(n.plan.format.n_channels(), 4);
  EXPECT_EQ(n.plan.format.x_dpi, 4000);
}

TEST(Plan, FocusesWhereNikonScanDoes) {
  // Recorded: X 1973, Y frame origin + 2979.
  const Negotiated n = negotiate({}, ls5000_strip());
  EXPECT_EQ(n.plan.focus_x_px, 1973);
  EXPECT_EQ(n.plan.focus_y_px, 2979);
}

TEST(Plan, RoundsToTheNextFinerResolutionAndSaysSo) {
  ScanRequest request;
  request.resolution_dpi = 1200;
  const Negotiated n = negotiate(request, ls5000_mount());
  EXPECT_EQ(n.plan.resolution_dpi, 2000);
  ASSERT_EQ(n.adjusted.size(), 1U);
  EXPECT_EQ(n.adjusted[0].field, "resolution");
  EXPECT_EQ(n.adjusted[0].granted, "2000 dpi");
  EXPECT_FALSE(n.adjusted[0].why.empty());
}

TEST(Plan, CropsAcrossInTheHostAndAlongInTheUnit) {
  ScanRequest request;
  request.area = {5.0, 7.0, 10.0, 12.0};
  const ScanPlan plan = negotiate(request, ls5000_mount()).plan;
  EXPECT_EQ(plan.x_origin_px, 0);
  EXPECT_EQ(plan.window_width_px, 3946);
  EXPECT_EQ(plan.crop_left_px, 787);
  EXPECT_EQ(plan.format.width_px, 1575);
  EXPECT_EQ(plan.y_origin_px, 1102);
  EXPECT_EQ(plan.format.n_lines, 1890);
}

TEST(Plan, NeverLeavesTheBoundary) {
  // A window past it drives the stage of larger units against its stop.
  std::mt19937 random(20261122);
  std::uniform_real_distribution<double> mm(-20, 80);
  for (const UnitDescription& unit : {ls5000_mount(), ls5000_strip(), ls50_strip()}) {
    for (int round = 0; round < 2000; ++round) {
      ScanRequest request;
      request.resolution_dpi = static_cast<int>(random() % 5000) + 1;
      request.area = {mm(random), mm(random), std::abs(mm(random)) + 0.1,
                      std::abs(mm(random)) + 0.1};
      // An area that begins beyond the frame is refused, never moved.
      if (*request.area.left_mm > 25 || *request.area.top_mm > 36.6) {
        if (*request.area.left_mm > 25.1 || *request.area.top_mm > 38) {
          EXPECT_THROW((void)negotiate(request, unit), InputError);
        }
        continue;
      }
      const ScanPlan plan = negotiate(request, unit).plan;
      ASSERT_GE(plan.y_origin_px, 0);
      ASSERT_LE(plan.y_origin_px + plan.window_height_px, unit.addresses.max_height_px);
      ASSERT_GE(plan.format.n_lines, 1);
      ASSERT_GE(plan.format.width_px, 1);
      ASSERT_LE(plan.crop_left_px + plan.format.width_px, plan.window_width_px / plan.pitch);
      ASSERT_TRUE(still_fits(plan, unit));
    }
  }
}

TEST(Plan, NegotiatingAPlanAgainAdjustsNothing) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> mm(0, 24);
  const UnitDescription unit = ls5000_mount();
  const auto to_mm = [](int px) { return px * 25.4 / 4000; };
  for (int round = 0; round < 500; ++round) {
    ScanRequest request;
    request.resolution_dpi = static_cast<int>(random() % 4000) + 1;
    request.area = {mm(random), mm(random), 0.1 + mm(random), 0.1 + mm(random)};
    const ScanPlan first = negotiate(request, unit).plan;
    request.resolution_dpi = first.resolution_dpi;
    request.depth_bits = first.depth_bits;
    request.area = {to_mm(first.crop_left_px * first.pitch), to_mm(first.y_origin_px),
                    to_mm(first.format.width_px * first.pitch), to_mm(first.window_height_px)};
    const Negotiated again = negotiate(request, unit);
    ASSERT_TRUE(again.adjusted.empty())
        << again.adjusted[0].field << " " << again.adjusted[0].asked;
    ASSERT_EQ(again.plan.format, first.format);
    ASSERT_EQ(again.plan.y_origin_px, first.y_origin_px);
    ASSERT_EQ(again.plan.crop_left_px, first.crop_left_px);
  }
}

TEST(Plan, TakesFramesFromTheTableOfTheUnit) {
  UnitDescription unit = ls5000_strip();
  unit.strip = {{840, {1, 0, 12}}, {7056, {9, 1, 14}}};
  ScanRequest request;
  request.frame = 2;
  EXPECT_EQ(negotiate(request, unit).plan.y_origin_px, 7056);
  request.frame = 3;
  EXPECT_EQ(negotiate(request, unit).plan.y_origin_px, 2 * 5959) << "not in the table";
  request.frame = 41;
  EXPECT_THROW((void)negotiate(request, unit), InputError);
}

TEST(Plan, RefusesWhatCannotBeMeant) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [&](auto change) {
    ScanRequest request;
    change(request);
    EXPECT_THROW((void)negotiate(request, ls5000_mount()), InputError);
  };
  refused([](ScanRequest& r) { r.resolution_dpi = 0; });
  refused([](ScanRequest& r) { r.frame = 0; });
  refused([](ScanRequest& r) { r.frame = 2; });
  refused([](ScanRequest& r) { r.area.width_mm = 0; });
  refused([&](ScanRequest& r) { r.area.left_mm = nan; });
  refused([&](ScanRequest& r) { r.area.height_mm = 1e300; });
  refused([&](ScanRequest& r) { r.exposure.factor = nan; });
  refused([](ScanRequest& r) { r.exposure.factor = 0; });
  refused([](ScanRequest& r) {
    r.exposure.mode = ExposureRequest::Mode::kFixed;
    r.exposure.exposure_us[3] = -1;
  });
  UnitDescription blind = ls5000_mount();
  blind.infrared = false;
  EXPECT_THROW((void)negotiate({}, blind), InputError) << "infrared is never left out silently";
  EXPECT_THROW((void)negotiate({}, UnitDescription{}), InputError) << "no adapter, no pages";
}

std::string all_plans() {
  std::ostringstream text;
  for (const UnitDescription& unit : {ls5000_mount(), ls5000_strip(), ls50_strip()}) {
    const Capabilities c = capabilities_of(unit);
    for (const int dpi : c.resolutions_dpi) {
      for (const int bits : c.depths_bits) {
        for (const bool infrared : {false, true}) {
          ScanRequest request;
          request.resolution_dpi = dpi;
          request.depth_bits = bits;
          request.infrared = infrared;
          text << "== " << c.model << " frames " << c.n_frames << " " << dpi << " dpi " << bits
               << " bits " << (infrared ? "RGBI" : "RGB") << "\n"
               << negotiate(request, unit).plan.describe();
        }
      }
    }
  }
  return text.str();
}

TEST(Plan, EveryResolutionDepthAndChannelSetIsAsItWas) {
  const std::string plans = all_plans();
  // The new text is always in the build tree, to be looked at and copied when a change is meant.
  std::ofstream(RESEAU_GOLDEN_OUT) << plans;
  std::ifstream file(RESEAU_GOLDEN_DIR "/plans.txt");
  std::stringstream golden;
  golden << file.rdbuf();
  EXPECT_TRUE(golden.str() == plans) << "differs from plans.txt; compare with " RESEAU_GOLDEN_OUT;
}

}  // namespace
}  // namespace reseau::coolscan
