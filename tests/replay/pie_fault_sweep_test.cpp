// Every transfer of a small scan on every simulated PIE unit fails once in every way, control
// requests included. Whatever happens: nothing hangs, stop() returns, lines that were delivered are
// right, and a unit that is still there scans again.
#include <algorithm>
#include <iostream>
#include <string>
#include <tuple>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "tests/replay/pie_scan.h"

namespace reseau {
namespace {

ScanRequest tiny_pie_request() {
  ScanRequest request;
  request.resolution_dpi = 200;
  request.area = {3.0, 4.0, 4.0, 3.0};
  request.exposure.mode = ExposureRequest::Mode::kFixed;
  return request;
}

std::string quiet(const std::string& unit) { return unit + "?noise=0&film=none&scene=chart"; }

struct PieSweep {
  std::vector<std::uint16_t> reference;
  long n_transfers = 0;
};

PieSweep reference_of_sweep(const std::string& unit) {
  auto link = std::make_unique<FaultTransport>(sim::open_simulated_unit(unit),
                                               Fault{Fault::Kind::kStall, 1L << 40});
  const FaultTransport& counter = *link;
  const auto scanner = open_pie(std::move(link));
  PieSweep sweep;
  sweep.reference = scan_of(*scanner, tiny_pie_request()).samples;
  sweep.n_transfers = counter.n_transfers();
  return sweep;
}

using PieCase = std::tuple<const char*, Fault::Kind>;
class PieFaultSweep : public testing::TestWithParam<PieCase> {};

TEST_P(PieFaultSweep, EveryTransfer) {
  const auto& [model, kind] = GetParam();
  const std::string unit = quiet(model);
  const PieSweep sweep = reference_of_sweep(unit);
  ASSERT_GT(sweep.n_transfers, 300);
  ASSERT_FALSE(sweep.reference.empty());
  int n_failed = 0, n_survived = 0;
  for (long n = 0; n < sweep.n_transfers; ++n) {
    SCOPED_TRACE("transfer " + std::to_string(n));
    std::unique_ptr<pieusb::Pieusb> scanner;
    Outcome outcome;
    try {
      scanner = open_pie(
          std::make_unique<FaultTransport>(sim::open_simulated_unit(unit), Fault{kind, n}));
      scan_into(*scanner, tiny_pie_request(), outcome);
    } catch (const DeviceError& error) {
      ++n_failed;
      ASSERT_NE(std::string(error.what()), "");
      if (kind == Fault::Kind::kDisconnect) {
        ASSERT_EQ(error.kind(), DeviceError::Kind::kDisconnected) << error.what();
      }
    }
    ASSERT_LE(outcome.samples.size(), sweep.reference.size());
    ASSERT_TRUE(
        std::equal(outcome.samples.begin(), outcome.samples.end(), sweep.reference.begin()));
    if (outcome.complete) {
      ++n_survived;
      ASSERT_EQ(outcome.samples.size(), sweep.reference.size());
    }
    if (scanner == nullptr) continue;
    scanner->stop();
    if (kind == Fault::Kind::kDisconnect) continue;
    // The fault is over: the unit has to be usable without switching it off.
    Outcome again;
    ASSERT_NO_THROW(scan_into(*scanner, tiny_pie_request(), again));
    ASSERT_EQ(again.samples, sweep.reference);
  }
  EXPECT_EQ(n_failed + n_survived, sweep.n_transfers);
  if (kind == Fault::Kind::kDisconnect) {
    EXPECT_EQ(n_survived, 0);
  } else {
    EXPECT_GT(n_survived, n_failed) << "most commands can be repeated";
  }
  std::cout << sweep.n_transfers << " cases: " << n_survived << " scans to the end, " << n_failed
            << " with a message\n";
}

std::string case_name(const testing::TestParamInfo<PieCase>& info) {
  static constexpr const char* kNames[] = {"Stall", "Timeout", "Short", "Disconnect"};
  return std::string(std::get<0>(info.param) + 4) +
         kNames[static_cast<std::size_t>(std::get<1>(info.param))];
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, PieFaultSweep,
    testing::Combine(testing::ValuesIn(kPieUnits),
                     testing::Values(Fault::Kind::kStall, Fault::Kind::kTimeout,
                                     Fault::Kind::kShort, Fault::Kind::kDisconnect)),
    case_name);

// A unit that falls silent for good: the message names the switch, stop() returns at once.
TEST(PieSilence, AUnitThatStaysSilentIsNotWaitedForTwice) {
  for (const char* const model : kPieUnits) {
    for (const int after : {5, 120, 400, 700}) {
      const std::string unit = quiet(model) + "&silent_after=" + std::to_string(after);
      try {
        const auto scanner = open_pie(unit);
        Outcome outcome;
        try {
          scan_into(*scanner, tiny_pie_request(), outcome);
          EXPECT_TRUE(outcome.complete);
        } catch (const DeviceError&) {
          scanner->stop();
          throw;
        }
      } catch (const DeviceError& error) {
        EXPECT_EQ(error.kind(), DeviceError::Kind::kTimeout);
        EXPECT_NE(std::string(error.what()).find("witch"), std::string::npos) << error.what();
      }
    }
  }
}

}  // namespace
}  // namespace reseau
