// Every transfer of a small scan fails once in every way. Whatever happens: nothing hangs, stop()
// returns, lines that were delivered are right, and a unit that is still there scans again.
#include <algorithm>
#include <string>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "tests/replay/simulated_scan.h"

namespace reseau {
namespace {

constexpr const char* kUnit = "sim:ls50?noise=0&film=none";

ScanRequest tiny_request() {
  ScanRequest request;
  request.resolution_dpi = 1000;
  request.area = {3.0, 4.0, 2.0, 0.9};  // three READs
  request.exposure.mode = ExposureRequest::Mode::kFixed;
  return request;
}

struct Sweep {
  std::vector<std::uint16_t> reference;
  long n_transfers = 0;
};

Sweep reference_scan() {
  auto link = std::make_unique<FaultTransport>(sim::open_simulated_unit(kUnit),
                                               Fault{Fault::Kind::kStall, 1L << 40});
  const FaultTransport& counter = *link;
  const auto scanner = open_coolscan(std::move(link));
  Sweep sweep;
  sweep.reference = scan_of(*scanner, tiny_request()).samples;
  sweep.n_transfers = counter.n_transfers();
  return sweep;
}

class FaultSweep : public testing::TestWithParam<Fault::Kind> {};

TEST_P(FaultSweep, EveryTransfer) {
  const Sweep sweep = reference_scan();
  ASSERT_GT(sweep.n_transfers, 100);
  ASSERT_FALSE(sweep.reference.empty());
  int n_failed = 0, n_survived = 0;
  for (long n = 0; n < sweep.n_transfers; ++n) {
    SCOPED_TRACE("transfer " + std::to_string(n));
    std::unique_ptr<coolscan::Coolscan> scanner;
    Outcome outcome;
    try {
      scanner = open_coolscan(
          std::make_unique<FaultTransport>(sim::open_simulated_unit(kUnit), Fault{GetParam(), n}));
      scan_into(*scanner, tiny_request(), outcome);
    } catch (const DeviceError& error) {
      ++n_failed;
      ASSERT_NE(std::string(error.what()), "");
      if (GetParam() == Fault::Kind::kDisconnect) {
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
    if (GetParam() == Fault::Kind::kDisconnect) continue;
    // The fault is over: the unit has to be usable without switching it off.
    Outcome again;
    ASSERT_NO_THROW(scan_into(*scanner, tiny_request(), again));
    ASSERT_EQ(again.samples, sweep.reference);
  }
  EXPECT_EQ(n_failed + n_survived, sweep.n_transfers);
  EXPECT_GT(n_failed, 0) << "a sweep in which nothing fails proves nothing";
  if (GetParam() != Fault::Kind::kDisconnect) {
    EXPECT_GT(n_survived, n_failed) << "most commands can be repeated";
  }
}

std::string kind_name(const testing::TestParamInfo<Fault::Kind>& kind) {
  static constexpr const char* kNames[] = {"Stall", "Timeout", "Short", "Disconnect"};
  return kNames[static_cast<std::size_t>(kind.param)];
}

INSTANTIATE_TEST_SUITE_P(Kinds, FaultSweep,
                         testing::Values(Fault::Kind::kStall, Fault::Kind::kTimeout,
                                         Fault::Kind::kShort, Fault::Kind::kDisconnect),
                         kind_name);

}  // namespace
}  // namespace reseau
