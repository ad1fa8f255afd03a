// A fault at the transfers of a scan of every model, through the session and into a master: the
// session returns, the master is a readable picture of exactly the lines that were committed, and
// the next open of the same unit works.
#include <algorithm>
#include <iostream>
#include <string>

#include <gtest/gtest.h>

#include "capture/image/scan_reader.h"
#include "capture/session/scan_session.h"
#include "capture/store/master_writer.h"
#include "core/base/error.h"
#include "drivers/registry.h"
#include "tests/support/temp_dir.h"

namespace reseau {
namespace {

class SilentSession final : public SessionObserver {
 public:
  void phase(ScanPhase /*phase*/, const std::string& /*detail*/) override {}
  void note(const std::string& /*sentence*/) override {}
  void began(const LineFormat& /*format*/, const CaptureContext& /*context*/) override {}
  void progress(int /*read*/, int /*committed*/, int /*n_lines*/) override {}
};

struct Case {
  std::string model;
  int dpi;
};

ScanRequest request_for(const Case& unit) {
  ScanRequest request;
  request.resolution_dpi = unit.dpi;
  request.area = {3.0, 4.0, 1.0, 1.0};
  request.exposure.mode = ExposureRequest::Mode::kFixed;
  request.focus.mode = FocusRequest::Mode::kKeep;
  return request;
}

std::vector<std::uint16_t> samples_of(const LineSource& source) {
  const LineFormat format = source.format();
  std::vector<std::uint16_t> samples(static_cast<std::size_t>(format.n_lines) *
                                     format.samples_per_line());
  source.read(0, format.n_lines, samples);
  return samples;
}

struct Kept {
  int lines = 0;                       // that the session says are in the master
  bool failed = false;                 // the unit could not be opened, or the scan did not end well
  std::vector<std::uint16_t> samples;  // of the file
  std::string message;
};

// "stall@7", or empty for none.
Kept scan_into_file(const Case& unit, const std::string& fault) {
  const test::TempDir dir;
  Kept kept;
  const std::string name = "sim:" + unit.model + "?noise=0&film=none&busy_polls=1" +
                           (fault.empty() ? "" : "&fault=" + fault);
  MasterOptions options;
  options.path = dir / "a.tif";
  MasterWriter master(options);
  SilentSession observer;
  try {
    const OpenedScanner opened = open_scanner(name, {});
    const ScanPlan plan = opened.scanner->negotiate(request_for(unit)).plan;
    ScanSession session(*opened.scanner, plan, master, [&master] { return master.source(); },
                        observer, {});
    const ScanOutcome outcome = session.run({});
    kept.lines = outcome.lines;
    kept.failed = outcome.end != ScanEnd::kComplete;
    if (outcome.error) std::rethrow_exception(outcome.error);
  } catch (const std::exception& error) {
    kept.failed = true;
    kept.message = error.what();
  }
  const std::filesystem::path file = master.result().path;
  if (!file.empty()) kept.samples = samples_of(*read_scan(file).source);
  return kept;
}

class MasterFaultSweep : public testing::TestWithParam<Case> {};

TEST_P(MasterFaultSweep, TheMasterHoldsWhatWasCommitted) {
  const Case& unit = GetParam();
  const Kept whole = scan_into_file(unit, "");
  ASSERT_FALSE(whole.failed) << whole.message;
  ASSERT_GT(whole.lines, 0);
  const std::size_t line_samples = whole.samples.size() / static_cast<std::size_t>(whole.lines);
  int n_cases = 0, n_failed = 0, n_partial = 0;
  // Every transfer while commands are sent, then in growing steps. A unit that is gone at a
  // transfer that never comes gives the whole scan: that is where the others end.
  long n_transfers = 1L << 20;
  for (const std::string kind : {"disconnect", "stall", "timeout", "short"}) {
    for (long n = 0; n < n_transfers; n += 1 + n / 16) {
      SCOPED_TRACE(kind + "@" + std::to_string(n));
      const Kept kept = scan_into_file(unit, kind + "@" + std::to_string(n));
      ++n_cases;
      n_failed += kept.failed ? 1 : 0;
      n_partial += kept.failed && kept.lines > 0 ? 1 : 0;
      ASSERT_EQ(kept.samples.size(), static_cast<std::size_t>(kept.lines) * line_samples);
      ASSERT_TRUE(std::equal(kept.samples.begin(), kept.samples.end(), whole.samples.begin()));
      if (kept.failed) {
        ASSERT_NE(kept.message, "");
      } else {
        ASSERT_EQ(kept.lines, whole.lines);
        if (kind == "disconnect") n_transfers = n;
      }
    }
  }
  EXPECT_GT(n_failed, 0);
  EXPECT_GT(n_partial, 0) << "the sweep never met the lines";
  std::cout << unit.model << ": " << n_cases << " cases, " << n_failed << " ended with an error, "
            << n_partial << " of them with lines in the master\n";
}

INSTANTIATE_TEST_SUITE_P(Models, MasterFaultSweep,
                         testing::Values(Case{"ls5000", 1000}, Case{"ls50", 1000},
                                         Case{"ls40", 725}, Case{"ls4000", 1000},
                                         Case{"ls8000", 1000}, Case{"ls9000", 1000},
                                         Case{"ls2000", 675}, Case{"ls30", 675}),
                         [](const auto& unit) { return unit.param.model; });

TEST(MasterFaults, AnUnpluggedUnitCostsNoCommittedLine) {
  const Case unit{"ls50", 1000};
  const Kept whole = scan_into_file(unit, "");
  ASSERT_FALSE(whole.failed) << whole.message;
  const Kept cut = scan_into_file(unit, "disconnect@100");
  EXPECT_TRUE(cut.failed);
  EXPECT_TRUE(std::equal(cut.samples.begin(), cut.samples.end(), whole.samples.begin()));
}

}  // namespace
}  // namespace reseau
