#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "drivers/coolscan/coolscan.h"
#include "drivers/fault_sg.h"
#include "drivers/scanner.h"
#include "drivers/scsi/sg_scsi.h"
#include "drivers/sim/simulated_unit.h"
#include "drivers/usb/fault_transport.h"
#include "drivers/virtual_clock.h"

namespace reseau {

class KeepingObserver final : public ScanObserver {
 public:
  void phase(ScanPhase, const std::string& detail) override { phases.push_back(detail); }
  void note(const std::string& sentence) override { notes.push_back(sentence); }
  std::vector<std::string> phases, notes;
};

// A corner of the first frame: quick, and every kind of command is in it.
inline ScanRequest small_request() {
  ScanRequest request;
  request.resolution_dpi = 500;
  request.area = {3.0, 4.0, 6.0, 3.0};
  return request;
}

inline std::unique_ptr<coolscan::Coolscan> open_coolscan(std::unique_ptr<UsbTransport> usb) {
  return std::make_unique<coolscan::Coolscan>(std::move(usb), std::make_shared<VirtualClock>(),
                                              coolscan::OpenAs{"sim:test", "2026-11-22T00:00:00Z"});
}

// A simulated unit on USB or behind a SCSI node, with one fault; counts what was sent.
struct FaultyUnit {
  std::unique_ptr<coolscan::Coolscan> scanner;
  std::function<long()> n_sent;
};
inline Fault no_fault() { return {Fault::Kind::kStall, 1L << 40}; }
inline FaultyUnit open_faulty(const std::string& name, const Fault& fault) {
  const sim::SimSpec spec = sim::parse_sim_spec(name);
  const auto clock = std::make_shared<VirtualClock>();
  const coolscan::OpenAs open_as{"sim:test", "2026-11-22T00:00:00Z"};
  if (!sim::is_scsi_model(spec)) {
    auto usb = std::make_unique<FaultTransport>(sim::open_simulated_unit(spec), fault);
    const FaultTransport* const counter = usb.get();
    return {std::make_unique<coolscan::Coolscan>(std::unique_ptr<UsbTransport>(std::move(usb)),
                                                 clock, open_as),
            [counter] { return counter->n_transfers(); }};
  }
  auto sg = std::make_unique<FaultSg>(sim::open_simulated_sg(spec), fault);
  const FaultSg* const counter = sg.get();
  return {std::make_unique<coolscan::Coolscan>(sg_scsi_link(std::move(sg), *clock), clock, open_as),
          [counter] { return counter->n_commands(); }};
}
inline std::unique_ptr<coolscan::Coolscan> open_any(const std::string& name) {
  return open_faulty(name, no_fault()).scanner;
}

// Every sample of a scan, and whether it came to its end.
struct Outcome {
  LineFormat format;
  CaptureContext context;
  std::vector<std::uint16_t> samples;
  bool complete = false;
};

// Appends to outcome as lines arrive, so that they are there when an exception passes.
inline void scan_into(Scanner& scanner, const ScanRequest& request, Outcome& outcome) {
  const ScanPlan plan = scanner.negotiate(request).plan;
  outcome = {};
  outcome.format = plan.format;
  KeepingObserver observer;
  if (!scanner.start(plan, observer, {})) return;
  outcome.context = scanner.context();
  LineBlock block;
  while (scanner.read(block, Duration(0)) == ReadStatus::kLines) {
    outcome.samples.insert(outcome.samples.end(), block.used().begin(), block.used().end());
  }
  outcome.complete = true;
}

inline Outcome scan_of(Scanner& scanner, const ScanRequest& request) {
  Outcome outcome;
  scan_into(scanner, request, outcome);
  return outcome;
}

}  // namespace reseau
