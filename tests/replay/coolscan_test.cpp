// The driver against simulated units.
#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "tests/replay/simulated_scan.h"

namespace reseau {
namespace {

std::unique_ptr<coolscan::Coolscan> open_sim(const std::string& name) {
  return open_coolscan(sim::open_simulated_unit(name));
}

TEST(Coolscan, KnowsTheUnitFromItsPages) {
  const auto ls5000 = open_sim("sim:ls5000");
  EXPECT_EQ(ls5000->capabilities().model, "LS-5000 ED");
  EXPECT_EQ(ls5000->capabilities().optical_dpi, 4000);
  EXPECT_EQ(ls5000->capabilities().depths_bits, std::vector<int>{16});
  EXPECT_TRUE(ls5000->capabilities().film_present);
  EXPECT_TRUE(ls5000->capabilities().infrared);
  const auto ls50 = open_sim("sim:ls50");
  EXPECT_EQ(ls50->capabilities().model, "LS-50 ED");
  EXPECT_EQ(ls50->capabilities().depths_bits, (std::vector<int>{8, 14}));
}

TEST(Coolscan, DeliversEveryLineOfThePlanOnce) {
  const auto scanner = open_sim("sim:ls5000");
  const ScanPlan plan = scanner->negotiate(small_request()).plan;
  KeepingObserver observer;
  ASSERT_TRUE(scanner->start(plan, observer, {}));
  LineBlock block;
  int next_line = 0;
  while (scanner->read(block, Duration(0)) == ReadStatus::kLines) {
    EXPECT_EQ(block.first_line, next_line);
    EXPECT_EQ(block.width_px, plan.format.width_px);
    EXPECT_EQ(block.n_channels, 4);
    next_line += block.n_lines;
  }
  EXPECT_EQ(next_line, plan.format.n_lines);
  EXPECT_EQ(scanner->read(block, Duration(0)), ReadStatus::kEndOfScan) << "and stays at the end";
}

TEST(Coolscan, SaysWhatItDoes) {
  const auto scanner = open_sim("sim:ls5000");
  KeepingObserver observer;
  ASSERT_TRUE(scanner->start(scanner->negotiate(small_request()).plan, observer, {}));
  ASSERT_GE(observer.phases.size(), 4U);
  EXPECT_EQ(observer.phases[1], "autofocus");
  EXPECT_EQ(observer.phases.back(), "scan");
  const CaptureContext& context = scanner->context();
  EXPECT_TRUE(context.focus_position);
  for (const auto& us : context.exposure_us) EXPECT_GT(us.value_or(0), 0);
  EXPECT_EQ(context.model, "LS-5000 ED");
  EXPECT_EQ(context.started_at_utc, "2026-11-22T00:00:00Z");
}

TEST(Coolscan, ScansAgainOnTheSameUnitWithTheSameResult) {
  const auto scanner = open_sim("sim:ls5000?noise=0");
  ScanRequest request = small_request();
  request.exposure.mode = ExposureRequest::Mode::kFixed;
  const Outcome first = scan_of(*scanner, request);
  const Outcome second = scan_of(*scanner, request);
  EXPECT_TRUE(first.complete);
  EXPECT_EQ(first.samples, second.samples);
}

TEST(Coolscan, AnAreaIsACutOutOfTheWholeFrame) {
  // Un-mirroring, cropping across in the host and positioning along in the unit.
  const auto scanner = open_sim("sim:ls5000?noise=0");
  ScanRequest request;
  request.resolution_dpi = 200;
  request.exposure.mode = ExposureRequest::Mode::kFixed;
  request.focus.mode = FocusRequest::Mode::kKeep;
  const Outcome whole = scan_of(*scanner, request);
  const int pitch = 20, left = 50, top = 100, width = 70, height = 60;
  const auto mm = [&](int px) { return px * pitch * 25.4 / 4000; };
  request.area = {mm(left), mm(top), mm(width), mm(height)};
  const Outcome part = scan_of(*scanner, request);
  ASSERT_EQ(part.format.width_px, width);
  ASSERT_EQ(part.format.n_lines, height);
  const int whole_width = whole.format.width_px;
  for (int line = 0; line < height; ++line) {
    for (int plane = 0; plane < 4; ++plane) {
      const auto from = whole.samples.begin() + ((top + line) * 4 + plane) * whole_width + left;
      const auto cut = part.samples.begin() + (line * 4 + plane) * width;
      ASSERT_TRUE(std::equal(cut, cut + width, from)) << "line " << line << " plane " << plane;
    }
  }
}

TEST(Coolscan, MetersSoThatNoElementOfTheScreenIsCutOff) {
  for (const char* const name : {"sim:ls5000", "sim:ls50"}) {
    const auto scanner = open_sim(name);
    ScanRequest request;
    request.resolution_dpi = 4000;
    request.area = {10.0, 10.0, 4.0, 3.0};
    const Outcome outcome = scan_of(*scanner, request);
    const auto n_full = std::count(outcome.samples.begin(), outcome.samples.end(), 65535);
    EXPECT_LT(static_cast<double>(n_full), 1e-4 * static_cast<double>(outcome.samples.size()));
    EXPECT_GT(*std::max_element(outcome.samples.begin(), outcome.samples.end()), 50000) << name;
  }
}

TEST(Coolscan, RgbOnlyHasThreePlanes) {
  const auto scanner = open_sim("sim:ls50");
  ScanRequest request = small_request();
  request.infrared = false;
  const Outcome outcome = scan_of(*scanner, request);
  EXPECT_TRUE(outcome.complete);
  EXPECT_EQ(outcome.samples.size(), 3 * static_cast<std::size_t>(outcome.format.width_px) *
                                        static_cast<std::size_t>(outcome.format.n_lines));
  EXPECT_FALSE(outcome.context.exposure_us[3]);
}

TEST(Coolscan, EightBitsOfAnLs50FillTheScale) {
  const auto scanner = open_sim("sim:ls50");
  ScanRequest request = small_request();
  request.depth_bits = 8;
  const Outcome outcome = scan_of(*scanner, request);
  EXPECT_TRUE(outcome.complete);
  EXPECT_EQ(outcome.format.significant_bits, 8);
  for (const std::uint16_t v : outcome.samples) ASSERT_EQ(v % 257, 0);
}

TEST(Coolscan, EveryResolutionOfTheLadderDelivers) {
  for (const char* const name : {"sim:ls5000", "sim:ls50"}) {
    const auto scanner = open_sim(name);
    const std::vector<int> ladder = scanner->capabilities().resolutions_dpi;
    for (std::size_t i = 0; i < ladder.size(); i += 5) {
      ScanRequest request = small_request();
      request.resolution_dpi = ladder[i];
      request.exposure.mode = ExposureRequest::Mode::kFixed;
      request.focus.mode = FocusRequest::Mode::kKeep;
      EXPECT_TRUE(scan_of(*scanner, request).complete) << name << " " << ladder[i];
    }
  }
}

TEST(Coolscan, AColdUnitIsWaitedFor) {
  const auto scanner = open_sim("sim:ls5000?cold=1");
  EXPECT_TRUE(scan_of(*scanner, small_request()).complete);
}

TEST(Coolscan, StaleAnswersOfAnEarlierProgramAreDrained) {
  const auto scanner = open_sim("sim:ls5000?stale=8");
  EXPECT_TRUE(scan_of(*scanner, small_request()).complete);
}

TEST(Coolscan, AMissingFilmIsSaid) {
  const auto scanner = open_sim("sim:ls5000?film=empty");
  EXPECT_FALSE(scanner->capabilities().film_present);
  KeepingObserver observer;
  try {
    (void)scanner->start(scanner->negotiate(small_request()).plan, observer, {});
    FAIL();
  } catch (const DeviceError& error) {
    EXPECT_EQ(error.kind(), DeviceError::Kind::kNoMedium);
  }
}

TEST(Coolscan, StopsBetweenTwoReadsAndScansAgain) {
  const auto scanner = open_sim("sim:ls5000?noise=0");
  ScanRequest request = small_request();
  request.resolution_dpi = 2000;
  request.exposure.mode = ExposureRequest::Mode::kFixed;
  KeepingObserver observer;
  ASSERT_TRUE(scanner->start(scanner->negotiate(request).plan, observer, {}));
  LineBlock block;
  ASSERT_EQ(scanner->read(block, Duration(0)), ReadStatus::kLines);
  scanner->stop();
  scanner->stop();
  EXPECT_EQ(scanner->read(block, Duration(0)), ReadStatus::kEndOfScan);
  EXPECT_TRUE(scan_of(*scanner, request).complete);
}

// Asks to stop when a phase begins.
class StoppingObserver final : public ScanObserver {
 public:
  StoppingObserver(std::string at, std::stop_source& source)
      : at_(std::move(at)), source_(source) {}
  void phase(ScanPhase, const std::string& detail) override {
    if (detail == at_) source_.request_stop();
  }
  void note(const std::string&) override {}

 private:
  std::string at_;
  std::stop_source& source_;
};

TEST(Coolscan, AStopRequestEndsEveryPhaseWithTheUnitUsable) {
  const auto scanner = open_sim("sim:ls5000");
  for (const char* const phase :
       {"waiting for the scanner", "autofocus", "exposure pass 1", "fine exposure pass 1"}) {
    ScanRequest request = small_request();
    request.resolution_dpi = 1000;
    std::stop_source source;
    StoppingObserver observer(phase, source);
    EXPECT_FALSE(scanner->start(scanner->negotiate(request).plan, observer, source.get_token()))
        << phase;
    EXPECT_TRUE(scan_of(*scanner, small_request()).complete) << "after " << phase;
  }
}

TEST(Coolscan, AScanThatAnotherProgramLeftOpenIsClosed) {
  // The same unit twice: the first driver goes without a word in the middle of a scan.
  class Borrowed final : public UsbTransport {
   public:
    explicit Borrowed(UsbTransport& usb) : usb_(usb) {}
    [[nodiscard]] const UsbIdentity& identity() const override { return usb_.identity(); }
    void bulk_out(Endpoint e, std::span<const std::byte> d, Duration t) override {
      if (gone) throw DeviceError(DeviceError::Kind::kDisconnected, "The test let go.", "");
      usb_.bulk_out(e, d, t);
    }
    std::size_t bulk_in(Endpoint e, std::span<std::byte> b, Duration t) override {
      if (gone) throw DeviceError(DeviceError::Kind::kDisconnected, "The test let go.", "");
      return usb_.bulk_in(e, b, t);
    }
    void clear_halt(Endpoint e) override { usb_.clear_halt(e); }
    void reset() override { usb_.reset(); }
    bool gone = false;

   private:
    UsbTransport& usb_;
  };
  const auto unit = sim::open_simulated_unit("sim:ls5000");
  auto borrowed = std::make_unique<Borrowed>(*unit);
  Borrowed& first_link = *borrowed;
  auto first = open_coolscan(std::move(borrowed));
  ScanRequest request = small_request();
  request.resolution_dpi = 2000;
  KeepingObserver observer;
  ASSERT_TRUE(first->start(first->negotiate(request).plan, observer, {}));
  LineBlock block;
  ASSERT_EQ(first->read(block, Duration(0)), ReadStatus::kLines);
  first_link.gone = true;
  first.reset();

  const auto second = open_coolscan(std::make_unique<Borrowed>(*unit));
  EXPECT_TRUE(scan_of(*second, small_request()).complete);
}

}  // namespace
}  // namespace reseau
