#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "core/base/clock.h"
#include "drivers/coolscan/ccd_curves.h"
#include "drivers/coolscan/models.h"
#include "drivers/coolscan/plan.h"
#include "drivers/coolscan/scan_pass.h"
#include "drivers/coolscan/unit.h"
#include "drivers/metering.h"
#include "drivers/open_as.h"
#include "drivers/scanner.h"
#include "drivers/scsi/scsi_link.h"
#include "drivers/settling.h"

namespace reseau::coolscan {

using reseau::OpenAs;

// A Nikon Coolscan film scanner, on USB or behind SG_IO (drivers/coolscan/README.md). Thread-bound.
// Owns the link; the unit is left idle and released when it is destroyed.
class Coolscan final : public Scanner {
 public:
  // Identifies the unit, waits until it has started up (up to three minutes when cold) and reads
  // what it can do. Throws DeviceError.
  Coolscan(ScsiLink link, std::shared_ptr<Clock> clock, OpenAs open_as);
  Coolscan(std::unique_ptr<UsbTransport> usb, const std::shared_ptr<Clock>& clock, OpenAs open_as)
      : Coolscan(usb_scsi_link(std::move(usb), *clock), clock, std::move(open_as)) {}
  ~Coolscan() override;
  Coolscan(const Coolscan&) = delete;
  Coolscan& operator=(const Coolscan&) = delete;

  [[nodiscard]] const Capabilities& capabilities() const override { return capabilities_; }
  [[nodiscard]] Negotiated negotiate(const ScanRequest& request) const override;
  [[nodiscard]] bool start(const ScanPlan& plan, ScanObserver& observer,
                           const std::stop_token& stop) override;
  [[nodiscard]] const CaptureContext& context() const override { return context_; }
  // A READ that was sent is always finished, whatever the timeout is: a unit that is left in the
  // middle of one has to be switched off. kNotReady is therefore never returned.
  [[nodiscard]] ReadStatus read(LineBlock& block, Duration timeout) override;
  void stop() noexcept override;
  void eject(ScanObserver& observer) override;
  void load(ScanObserver& observer) override;

 private:
  // A unit that was switched on a moment ago answers after tens of seconds.
  static constexpr Duration kColdStart = std::chrono::seconds(180);

  void describe_unit();
  void read_curves();
  const Model* identify();  // absent for a unit that is no scanner of this family
  void read_film_state();
  bool prepare(const ScanPlan& plan, ScanObserver& observer, const std::stop_token& stop);
  void send_tables(bool infrared);
  // Tells the unit where the frames are, this plan's frame moved as it says.
  void send_frames(const ScanPlan& plan);
  // After the last line of an overview: where the frames are on the film.
  void finish_overview();
  void focus(const ScanPlan& plan, ScanObserver& observer);
  // Absent when stopped.
  std::optional<Exposures> settle_exposures(const ScanPlan& plan, ScanObserver& observer,
                                            const std::stop_token& stop);
  bool meter(const ScanPlan& plan, Metering& metering, ScanObserver& observer,
             const std::stop_token& stop);
  // Passes like this one until the exposures settle. Absent when stopped.
  std::optional<Measurement> settle(PassSpec spec, const std::string& what, Metering& metering,
                                    ScanObserver& observer, const std::stop_token& stop);
  std::optional<Measurement> measure(const PassSpec& spec, const std::stop_token& stop);
  [[nodiscard]] Exposures white_balance();
  void enter(ScanObserver& observer, ScanPhase phase, const std::string& detail);
  [[nodiscard]] PassRules pass_rules() const;

  std::shared_ptr<Clock> clock_;
  ScsiLink link_;
  Unit unit_;
  OpenAs open_as_;
  UnitDescription description_;
  Capabilities capabilities_;
  CurveSet curves_;
  std::vector<FrameRecord> table_in_unit_;  // data type 8F
  CaptureContext context_;
  std::optional<ScanPass> pass_;
  bool overview_ = false;
  std::vector<std::uint16_t> overview_samples_;
  LineFormat format_;
  int next_line_ = 0;
};

}  // namespace reseau::coolscan
