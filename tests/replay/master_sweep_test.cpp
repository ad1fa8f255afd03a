// A fault at every transfer of a whole scan, of every model and every kind, through the session and
// into a master: the session returns, the master is a readable picture of exactly the lines that
// were committed, and the same unit scans again for the next program, or the message names the
// power switch.
#include <algorithm>
#include <iostream>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "capture/image/scan_reader.h"
#include "capture/session/scan_session.h"
#include "capture/store/master_writer.h"
#include "core/base/error.h"
#include "drivers/families.h"
#include "tests/replay/simulated_scan.h"
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
  double height_mm;     // three READs of image lines, or more
  double width_mm = 0;  // 0: all of it
};

// What happens to a transfer: on its way, or in the unit itself.
enum class Trouble { kStall, kTimeout, kShort, kUnplugged, kGarbage, kSilent };
constexpr Trouble kTroubles[] = {Trouble::kStall,     Trouble::kTimeout, Trouble::kShort,
                                 Trouble::kUnplugged, Trouble::kGarbage, Trouble::kSilent};

std::string name_of(Trouble trouble) {
  static constexpr const char* kNames[] = {"Stall",     "Timeout", "Short",
                                           "Unplugged", "Garbage", "Silent"};
  return kNames[static_cast<std::size_t>(trouble)];
}

// The unit outlives the programs that use it, one after another.
class LentUsb final : public UsbTransport {
 public:
  explicit LentUsb(std::shared_ptr<UsbTransport> unit) : unit_(std::move(unit)) {}
  const UsbIdentity& identity() const override { return unit_->identity(); }
  void bulk_out(Endpoint endpoint, std::span<const std::byte> data, Duration timeout) override {
    unit_->bulk_out(endpoint, data, timeout);
  }
  std::size_t bulk_in(Endpoint endpoint, std::span<std::byte> buffer, Duration timeout) override {
    return unit_->bulk_in(endpoint, buffer, timeout);
  }
  void control_out(const ControlRequest& request, std::span<const std::byte> data,
                   Duration timeout) override {
    unit_->control_out(request, data, timeout);
  }
  std::size_t control_in(const ControlRequest& request, std::span<std::byte> buffer,
                         Duration timeout) override {
    return unit_->control_in(request, buffer, timeout);
  }
  void clear_halt(Endpoint endpoint) override { unit_->clear_halt(endpoint); }
  void reset() override { unit_->reset(); }

 private:
  std::shared_ptr<UsbTransport> unit_;
};

class LentSg final : public SgNode {
 public:
  explicit LentSg(std::shared_ptr<SgNode> unit) : unit_(std::move(unit)) {}
  void exchange(SgExchange& exchange) override { unit_->exchange(exchange); }

 private:
  std::shared_ptr<SgNode> unit_;
};

// What a program opens: the driver on the unit, with a fault in between.
struct Bench {
  std::shared_ptr<UsbTransport> usb;
  std::shared_ptr<SgNode> sg;

  explicit Bench(const std::string& name) {
    const sim::SimSpec spec = sim::parse_sim_spec(name);
    if (sim::is_scsi_model(spec)) {
      sg = sim::open_simulated_sg(spec);
    } else {
      usb = sim::open_simulated_unit(spec);
    }
  }
  // `n_sent`, where given, tells how much was sent so far while the driver lives.
  std::unique_ptr<Scanner> open(const Fault& fault, std::function<long()>* n_sent = nullptr) const {
    const auto clock = std::make_shared<VirtualClock>();
    const OpenAs open_as{"sim:test", "2026-11-22T00:00:00Z"};
    if (sg != nullptr) {
      auto link = std::make_unique<FaultSg>(std::make_unique<LentSg>(sg), fault);
      if (n_sent != nullptr) *n_sent = [counter = link.get()] { return counter->n_commands(); };
      return std::make_unique<coolscan::Coolscan>(sg_scsi_link(std::move(link), *clock), clock,
                                                  open_as);
    }
    auto link = std::make_unique<FaultTransport>(std::make_unique<LentUsb>(usb), fault);
    if (n_sent != nullptr) *n_sent = [counter = link.get()] { return counter->n_transfers(); };
    return open_family(std::move(link), clock, open_as);
  }
};

std::string name_of(const Case& unit, const std::string& trouble = "") {
  return "sim:" + unit.model + "?noise=0&film=none&cells=1&busy_polls=1" +
         (trouble.empty() ? "" : "&" + trouble);
}

ScanRequest request_for(const Case& unit) {
  ScanRequest request;
  request.resolution_dpi = unit.dpi;
  request.area.top_mm = 4.0;
  request.area.height_mm = unit.height_mm;
  if (unit.width_mm > 0) {
    request.area.left_mm = 4.0;
    request.area.width_mm = unit.width_mm;
  }
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
  long n_sent = 0;
};

Kept scan_into_file(const Bench& bench, const ScanRequest& request, const Fault& fault) {
  const test::TempDir dir(test::memory_folder());
  Kept kept;
  MasterOptions options;
  options.path = dir / "a.tif";
  MasterWriter master(options);
  SilentSession observer;
  try {
    std::function<long()> n_sent;
    const std::unique_ptr<Scanner> scanner = bench.open(fault, &n_sent);
    const ScanPlan plan = scanner->negotiate(request).plan;
    ScanSession session(*scanner, plan, master, [&master] { return master.source(); }, observer,
                        {});
    const ScanOutcome outcome = session.run({});
    kept.lines = outcome.lines;
    kept.failed = outcome.end != ScanEnd::kComplete;
    kept.n_sent = n_sent();
    if (outcome.error) std::rethrow_exception(outcome.error);
  } catch (const std::exception& error) {
    kept.failed = true;
    kept.message = error.what();
  }
  const std::filesystem::path file = master.result().path;
  if (!file.empty()) kept.samples = samples_of(*read_scan(file).source);
  return kept;
}

// The next program on the same unit. Empty when it scans the whole picture, else what it says.
std::string next_program(const Bench& bench, const ScanRequest& request, const Kept& whole) {
  try {
    const std::unique_ptr<Scanner> scanner = bench.open(no_fault());
    const Outcome again = scan_of(*scanner, request);
    return again.complete && again.samples == whole.samples ? "" : "the picture is another one";
  } catch (const std::exception& error) {
    return error.what();
  }
}

struct Counts {
  int cases = 0, failed = 0, partial = 0, switched = 0;
};

void expect_kept(const Kept& kept, const Kept& whole, Counts& counts) {
  const std::size_t line_samples = whole.samples.size() / static_cast<std::size_t>(whole.lines);
  ++counts.cases;
  ASSERT_EQ(kept.samples.size(), static_cast<std::size_t>(kept.lines) * line_samples);
  ASSERT_TRUE(std::equal(kept.samples.begin(), kept.samples.end(), whole.samples.begin()));
  if (kept.failed) {
    ++counts.failed;
    counts.partial += kept.lines > 0 ? 1 : 0;
    ASSERT_NE(kept.message, "");
  } else {
    ASSERT_EQ(kept.lines, whole.lines);
  }
}

// The same unit for the next program; one whose cable was pulled is plugged in again. Only where
// it stays silent the switch is all that helps.
void expect_next(const Bench& bench, const ScanRequest& request, const Kept& kept,
                 const Kept& whole, Counts& counts) {
  const std::string next = next_program(bench, request, whole);
  if (next.empty()) return;
  ++counts.switched;
  ASSERT_NE(next.find("witch"), std::string::npos) << kept.message << " Then: " << next;
}

Fault fault_of(Trouble trouble, long n) {
  static constexpr Fault::Kind kKinds[] = {Fault::Kind::kStall, Fault::Kind::kTimeout,
                                           Fault::Kind::kShort, Fault::Kind::kDisconnect};
  return {kKinds[static_cast<std::size_t>(trouble)], n};
}

// The trouble at transfers 0, step, 2 step … What strikes in the unit is counted over all that it
// answers.
void sweep(const Case& unit, Trouble trouble, long step, const Kept& whole, Counts& counts) {
  const ScanRequest request = request_for(unit);
  const bool in_unit = trouble == Trouble::kGarbage || trouble == Trouble::kSilent;
  const std::string key = trouble == Trouble::kGarbage ? "garbage_after=" : "silent_after=";
  for (long n = 0; n < whole.n_sent; n += step) {
    SCOPED_TRACE(name_of(trouble) + " at " + std::to_string(n));
    const Bench bench(name_of(unit, in_unit ? key + std::to_string(n + 1) : ""));
    const Kept kept = scan_into_file(bench, request, in_unit ? no_fault() : fault_of(trouble, n));
    expect_kept(kept, whole, counts);
    if (kept.failed) expect_next(bench, request, kept, whole, counts);
    if (testing::Test::HasFatalFailure()) return;
  }
}

Kept whole_scan(const Case& unit) {
  Kept whole = scan_into_file(Bench(name_of(unit)), request_for(unit), no_fault());
  EXPECT_FALSE(whole.failed) << whole.message;
  EXPECT_GT(whole.lines, 0);
  return whole;
}

Counts sweep(const Case& unit, long step) {
  Counts counts;
  const Kept whole = whole_scan(unit);
  if (whole.failed) return counts;
  for (const Trouble trouble : kTroubles) {
    sweep(unit, trouble, step, whole, counts);
    if (testing::Test::HasFatalFailure()) break;
  }
  return counts;
}

void print(const std::string& what, const Counts& counts) {
  std::cout << what << ": " << counts.cases << " cases, " << counts.failed
            << " ended with an error, " << counts.partial << " of them with lines in the master; "
            << counts.switched << " times the unit has to be switched off, which is said\n";
}

// So that the lines come in three READs or more.
const std::vector<Case>& coolscans() {
  static const std::vector<Case> kCases = {
      {"ls5000", 4000, 0.08}, {"ls50", 4000, 0.08},  {"ls40", 2900, 0.14},   {"ls4000", 4000, 0.08},
      {"ls8000", 2000, 0.5},  {"ls9000", 2000, 0.5}, {"ls2000", 2700, 0.18}, {"ls30", 2700, 0.18}};
  return kCases;
}

// A PIE scan is a thousand transfers, so it is narrow, and each kind of trouble a test of its own.
const std::vector<Case>& pie_units() {
  static const std::vector<Case> kCases = {
      {"crystalscan3600", 1200, 2.5, 0.25}, {"crystalscan7200", 1200, 2.5, 0.25},
      {"proscan7200", 1200, 2.5, 0.25},     {"proscan10t", 1000, 3, 0.25},
      {"digitdia5000", 1200, 2.5, 0.25},    {"digitdia6000", 1000, 3, 0.25},
      {"rps7200", 1200, 2.5, 0.25}};
  return kCases;
}

class MasterFaultSweep : public testing::TestWithParam<Case> {};

TEST_P(MasterFaultSweep, TheMasterHoldsWhatWasCommitted) {
  const Counts counts = sweep(GetParam(), 1);
  EXPECT_GT(counts.failed, 0);
  EXPECT_GT(counts.partial, 0) << "the sweep never met the lines";
  print(GetParam().model, counts);
}

INSTANTIATE_TEST_SUITE_P(Models, MasterFaultSweep, testing::ValuesIn(coolscans()),
                         [](const auto& unit) { return unit.param.model; });

using PieCase = std::tuple<Case, Trouble>;
class PieMasterFaultSweep : public testing::TestWithParam<PieCase> {};

TEST_P(PieMasterFaultSweep, TheMasterHoldsWhatWasCommitted) {
  const auto& [unit, trouble] = GetParam();
  const Kept whole = whole_scan(unit);
  ASSERT_FALSE(whole.failed);
  Counts counts;
  sweep(unit, trouble, 1, whole, counts);
  EXPECT_GT(counts.cases, 300);
  EXPECT_GT(counts.failed, 0);
  EXPECT_GT(counts.partial, 0) << "the sweep never met the lines";
  print(unit.model + ", " + name_of(trouble), counts);
}

INSTANTIATE_TEST_SUITE_P(Models, PieMasterFaultSweep,
                         testing::Combine(testing::ValuesIn(pie_units()),
                                          testing::ValuesIn(kTroubles)),
                         [](const auto& unit) {
                           return std::get<0>(unit.param).model + name_of(std::get<1>(unit.param));
                         });

// A few of the same cases, cheap enough for a sanitizer: other places for each model.
TEST(MasterFaults, SomePlacesOfEveryModel) {
  long step = 97;
  for (const auto* const units : {&coolscans(), &pie_units()}) {
    for (const Case& unit : *units) {
      SCOPED_TRACE(unit.model);
      const Counts counts = sweep(unit, units == &coolscans() ? step : 5 * step);
      EXPECT_GT(counts.failed, 0);
      step += 2;
    }
  }
}

}  // namespace
}  // namespace reseau
