// Every transfer, or every command, of a small scan of every model fails once in every way.
#include <algorithm>
#include <iostream>
#include <string>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "tests/replay/simulated_scan.h"

namespace reseau {
namespace {

struct Unit {
  std::string name;
  int dpi;
  int samples;
  SensorLines lines;
};

ScanRequest request_for(const Unit& unit) {
  ScanRequest request;
  request.resolution_dpi = unit.dpi;
  request.area = {3.0, 4.0, 1.0, 0.12};
  request.exposure.mode = ExposureRequest::Mode::kFixed;
  request.samples = unit.samples;
  request.sensor_lines = unit.lines;
  return request;
}

class ModelFaultSweep : public testing::TestWithParam<Unit> {};

TEST_P(ModelFaultSweep, EveryTransferInEveryWay) {
  const Unit& unit = GetParam();
  const std::string name = "sim:" + unit.name + "?noise=0&film=none&busy_polls=1";
  std::vector<std::uint16_t> reference;
  long n_sent = 0;
  {
    const FaultyUnit good = open_faulty(name, no_fault());
    reference = scan_of(*good.scanner, request_for(unit)).samples;
    n_sent = good.n_sent();
  }
  ASSERT_FALSE(reference.empty());
  long n_cases = 0, n_failed = 0;
  for (const Fault::Kind kind : {Fault::Kind::kStall, Fault::Kind::kTimeout, Fault::Kind::kShort,
                                 Fault::Kind::kDisconnect}) {
    for (long n = 0; n < n_sent; ++n, ++n_cases) {
      SCOPED_TRACE("kind " + std::to_string(static_cast<int>(kind)) + " transfer " +
                   std::to_string(n));
      FaultyUnit faulty;
      Outcome outcome;
      try {
        faulty = open_faulty(name, {kind, n});
        scan_into(*faulty.scanner, request_for(unit), outcome);
      } catch (const DeviceError& error) {
        ++n_failed;
        ASSERT_NE(std::string(error.what()), "");
      }
      ASSERT_LE(outcome.samples.size(), reference.size());
      ASSERT_TRUE(std::equal(outcome.samples.begin(), outcome.samples.end(), reference.begin()));
      if (faulty.scanner == nullptr) continue;
      faulty.scanner->stop();
      if (kind == Fault::Kind::kDisconnect) continue;
      Outcome again;
      ASSERT_NO_THROW(scan_into(*faulty.scanner, request_for(unit), again));
      ASSERT_TRUE(again.samples == reference);
    }
  }
  EXPECT_GT(n_failed, 0) << "a sweep in which nothing fails proves nothing";
  std::cout << unit.name << ": " << n_cases << " cases, " << n_failed << " ended with an error\n";
}

std::string sweep_name(const testing::TestParamInfo<Unit>& unit) { return unit.param.name; }

INSTANTIATE_TEST_SUITE_P(Models, ModelFaultSweep,
                         testing::Values(Unit{"ls5000", 4000, 2, SensorLines::kAll},
                                         Unit{"ls50", 2000, 1, SensorLines::kOne},
                                         Unit{"ls40", 1450, 1, SensorLines::kOne},
                                         Unit{"ls4000", 2000, 2, SensorLines::kOne},
                                         Unit{"ls8000", 2000, 1, SensorLines::kAll},
                                         Unit{"ls9000", 2000, 1, SensorLines::kAll},
                                         Unit{"ls2000", 1350, 1, SensorLines::kOne},
                                         Unit{"ls30", 1350, 1, SensorLines::kOne}),
                         sweep_name);

}  // namespace
}  // namespace reseau
