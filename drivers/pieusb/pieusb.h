#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/base/clock.h"
#include "drivers/open_as.h"
#include "drivers/pieusb/bridge.h"
#include "drivers/pieusb/plan.h"
#include "drivers/pieusb/scan_pass.h"
#include "drivers/pieusb/unit.h"
#include "drivers/scanner.h"
#include "drivers/settling.h"
#include "drivers/usb/usb_transport.h"

namespace reseau::pieusb {

// A PIE film scanner, sold by Reflecta and Braun too (drivers/pieusb/README.md). Thread-bound. Owns
// the transport; nothing of a pass is left in the unit when it is destroyed.
class Pieusb final : public Scanner {
 public:
  // Identifies the unit, waits until its lamp is warm (up to three minutes) and reads what it can
  // do. Throws DeviceError.
  Pieusb(std::unique_ptr<UsbTransport> usb, std::shared_ptr<Clock> clock, OpenAs open_as);
  ~Pieusb() override;
  Pieusb(const Pieusb&) = delete;
  Pieusb& operator=(const Pieusb&) = delete;

  [[nodiscard]] const Capabilities& capabilities() const override { return capabilities_; }
  [[nodiscard]] Negotiated negotiate(const ScanRequest& request) const override;
  [[nodiscard]] bool start(const ScanPlan& plan, ScanObserver& observer,
                           const std::stop_token& stop) override;
  [[nodiscard]] const CaptureContext& context() const override { return context_; }
  // Blocks until a READ is done, whatever the timeout is; kNotReady is never returned.
  [[nodiscard]] ReadStatus read(LineBlock& block, Duration timeout) override;
  // Reads the rest of the pass, which can take as long as the scan would have.
  void stop() noexcept override;
  [[nodiscard]] std::string stop_notice() const override;

 private:
  bool prepare(const ScanPlan& plan, ScanObserver& observer, const std::stop_token& stop);
  // Absent when stopped.
  std::optional<Exposures> settle_exposures(const ScanPlan& plan, ScanObserver& observer,
                                            const std::stop_token& stop);
  std::optional<Measurement> settle(PassSpec spec, const std::string& what, Metering& metering,
                                    ScanObserver& observer, const std::stop_token& stop);
  std::optional<Measurement> measure(const PassSpec& spec, const std::stop_token& stop);
  void tell_shading(const Shading& shading, ScanObserver& observer) const;
  void enter(ScanObserver& observer, ScanPhase phase, const std::string& detail);

  std::shared_ptr<Clock> clock_;
  std::unique_ptr<UsbTransport> usb_;
  PieBridge bridge_;
  Unit unit_;
  OpenAs open_as_;
  UnitDescription description_;
  Capabilities capabilities_;
  PassMemory memory_;
  CaptureContext context_;
  std::optional<ScanPass> pass_;
  LineFormat format_;
  int next_line_ = 0;
};

}  // namespace reseau::pieusb
