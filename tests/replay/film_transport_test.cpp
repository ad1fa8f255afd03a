// Overviews, frames, eject, load, unstick.
#include <cmath>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "drivers/coolscan/unstick.h"
#include "drivers/registry.h"
#include "drivers/scsi/nikon_usb_scsi.h"
#include "tests/replay/simulated_scan.h"

namespace reseau {
namespace {

// Frames with a gap that a thumbnail line can see.
const std::string kStrip = "sim:ls5000?noise=0&adapter=sa21&frames=4&border_px=90&scene=natural";

Outcome overview_of(Scanner& scanner) {
  ScanRequest request;
  request.overview = true;
  return scan_of(scanner, request);
}

TEST(FilmTransport, AnOverviewShowsTheWholeStripAndFindsTheFrames) {
  const auto scanner = open_any(kStrip);
  EXPECT_TRUE(scanner->capabilities().can_overview);
  EXPECT_EQ(scanner->capabilities().n_frames, 6) << "the adapter's, before the unit has counted";
  const Outcome overview = overview_of(*scanner);
  ASSERT_TRUE(overview.complete);
  EXPECT_EQ(overview.format.width_px, 96);
  EXPECT_EQ(overview.format.n_channels(), 3);
  EXPECT_EQ(overview.format.n_lines, 8 * 5959 / 41);
  const Capabilities& c = scanner->capabilities();
  EXPECT_EQ(c.n_frames, 4);
  for (std::size_t k = 0; k < c.frames.size(); ++k) {
    EXPECT_TRUE(c.frames[k].found);
    EXPECT_NEAR(c.frames[k].top_mm, static_cast<double>(k) * 5959 * 25.4 / 4000, 0.5) << k;
  }
}

TEST(FilmTransport, AThumbnailMayEndWithTheFilm) {
  const auto scanner = open_any(kStrip + "&early_end=1");
  const Outcome overview = overview_of(*scanner);
  ASSERT_TRUE(overview.complete);
  EXPECT_LT(overview.samples.size(),
            overview.format.samples_per_line() * static_cast<std::size_t>(overview.format.n_lines));
  ScanRequest request = small_request();
  request.frame = 2;
  EXPECT_TRUE(scan_of(*scanner, request).complete) << "the unit is free";
}

TEST(FilmTransport, OverviewsOfOtherAdaptersAndUnits) {
  for (const char* const name :
       {"sim:ls50", "sim:ls40", "sim:ls5000?adapter=mount", "sim:ls50?adapter=aps&frames=3",
        "sim:ls4000", "sim:ls9000?film=none", "sim:ls8000?film=none", "sim:ls2000"}) {
    SCOPED_TRACE(name);
    const auto scanner = open_any(name);
    EXPECT_TRUE(overview_of(*scanner).complete);
  }
}

TEST(FilmTransport, AFrameMovesByAQuarterOfAMillimetre) {
  const auto scanner = open_any(kStrip);
  ScanRequest request = small_request();
  request.resolution_dpi = 4000;
  request.area = {10.0, 10.0, 1.5, 1.5};
  request.exposure.mode = ExposureRequest::Mode::kFixed;
  request.focus.mode = FocusRequest::Mode::kKeep;
  request.frame = 2;
  const Outcome still = scan_of(*scanner, request);
  for (const double offset_mm : {0.25, -0.25, 0.5}) {
    request.frame_offset_mm = offset_mm;
    const int moved_px = scanner->negotiate(request).plan.frame_offset_px;
    EXPECT_NEAR(moved_px, offset_mm * 4000 / 25.4, 4);
    const Outcome there = scan_of(*scanner, request);
    const auto line = static_cast<std::ptrdiff_t>(still.format.samples_per_line());
    const auto skip = std::abs(moved_px) * line;
    const auto n = static_cast<std::ptrdiff_t>(still.samples.size()) - skip;
    const auto& ahead = moved_px > 0 ? still : there;
    const auto& behind = moved_px > 0 ? there : still;
    EXPECT_TRUE(std::equal(ahead.samples.begin() + skip, ahead.samples.end(),
                           behind.samples.begin(), behind.samples.begin() + n))
        << offset_mm;
  }
  request.frame_offset_mm = 0;
  EXPECT_TRUE(scan_of(*scanner, request).samples == still.samples) << "and back";
}

TEST(FilmTransport, EjectsOnceAndKnowsThatTheFilmIsGone) {
  const auto scanner = open_any("sim:ls5000");
  ASSERT_TRUE(scanner->capabilities().can_eject);
  KeepingObserver observer;
  scanner->eject(observer);
  EXPECT_FALSE(scanner->capabilities().film_present);
  EXPECT_THROW((void)scan_of(*scanner, small_request()), DeviceError);
}

TEST(FilmTransport, WithoutAMotorTheHandIsAskedFor) {
  const auto scanner = open_any("sim:ls5000?adapter=mount");
  EXPECT_FALSE(scanner->capabilities().can_eject);
  KeepingObserver observer;
  EXPECT_THROW(scanner->eject(observer), InputError);
  EXPECT_THROW(scanner->load(observer), InputError);
  EXPECT_TRUE(scan_of(*scanner, small_request()).complete);
}

TEST(FilmTransport, AFeederLoadsSlideAfterSlideUntilItIsEmpty) {
  const auto scanner = open_any("sim:ls5000?adapter=feeder&slides=2");
  EXPECT_FALSE(scanner->capabilities().film_present);
  ASSERT_TRUE(scanner->capabilities().can_load);
  KeepingObserver observer;
  for (int slide = 0; slide < 2; ++slide) {
    scanner->load(observer);
    EXPECT_TRUE(scanner->capabilities().film_present);
    EXPECT_TRUE(scan_of(*scanner, small_request()).complete);
    if (scanner->capabilities().can_eject) scanner->eject(observer);
  }
  EXPECT_THROW(scanner->load(observer), DeviceError);
}

TEST(FilmTransport, AMissingAdapterIsSaid) {
  try {
    const auto scanner = open_any("sim:ls5000?adapter=none");
    (void)scanner->negotiate(small_request());
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("adapter"), std::string::npos);
  } catch (const DeviceError& error) {
    EXPECT_NE(std::string(error.what()).find("adapter"), std::string::npos) << error.what();
  }
}

UnstickReport unstick(const std::string& name, std::vector<std::string>* talk = nullptr) {
  return unstick_device(name, [talk](const std::string& tried, const std::string& result) {
    if (talk != nullptr) talk->push_back(tried + ": " + result);
  });
}

TEST(Unstick, FindsNothingWrongWithAGoodUnit) {
  for (const char* const name : {"sim:ls5000", "sim:ls50?film=empty", "sim:ls40", "sim:ls9000",
                                 "sim:ls5000?stale=64", "sim:ls50?cold=1"}) {
    std::vector<std::string> talk;
    EXPECT_EQ(unstick(name, &talk), UnstickReport::kWasFine) << name;
    EXPECT_FALSE(talk.empty());
  }
}

TEST(Unstick, NamesThePowerSwitchWhenNothingAnswers) {
  std::vector<std::string> talk;
  EXPECT_EQ(unstick("sim:ls5000?silent_after=1", &talk), UnstickReport::kNeedsPowerSwitch);
  EXPECT_NE(talk.back().find("switch the scanner off"), std::string::npos);
}

TEST(Unstick, EndsAScanThatAnotherProgramLeftOpen) {
  VirtualClock clock;
  const auto usb = sim::open_simulated_unit("sim:ls5000");
  NikonUsbScsi scsi(*usb, clock);
  {
    coolscan::Unit unit(scsi, clock);
    unit.wait_ready(Duration(std::chrono::seconds(10)));
    unit.set_units_per_inch(4000);
    coolscan::Window window;
    window.resolution_dpi = 500;
    window.width_px = 3946;
    window.height_px = 800;
    for (const auto colour :
         {coolscan::Colour::kRed, coolscan::Colour::kGreen, coolscan::Colour::kBlue}) {
      window.colour = colour;
      window.exposure_10ns = 50000;
      unit.set_window(window);
    }
    (void)unit.start_scan(
        {coolscan::Colour::kRed, coolscan::Colour::kGreen, coolscan::Colour::kBlue});
  }
  const coolscan::Unstuck result =
      coolscan::unstick(scsi, clock, [](const std::string&, const std::string&) {});
  EXPECT_NE(result, coolscan::Unstuck::kNeedsPowerSwitch);
  Bytes block(coolscan::kParameterBytes);
  EXPECT_TRUE(scsi.receive(coolscan::get_parameter(coolscan::Operation::kMoveFocus), block,
                           Duration(std::chrono::seconds(1)))
                  .good);
}

}  // namespace
}  // namespace reseau
