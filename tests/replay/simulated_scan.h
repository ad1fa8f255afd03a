#pragma once

#include <memory>
#include <string>
#include <vector>

#include "drivers/coolscan/coolscan.h"
#include "drivers/scanner.h"
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
