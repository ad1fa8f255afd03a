// What a scan says while it runs.
#pragma once

#include <string>

#include "capture/cli/reporter.h"
#include "capture/cli/scan_page.h"
#include "capture/session/scan_session.h"
#include "drivers/scan_plan.h"
#include "drivers/scanner.h"

namespace reseau::cli {

// Thread-safe, as SessionObserver asks.
class ScanTalk final : public SessionObserver {
 public:
  // The page, if any, is told how far the scan is.
  explicit ScanTalk(Reporter& reporter, ScanPage* page = nullptr)
      : reporter_(reporter), page_(page) {}
  void phase(ScanPhase phase, const std::string& detail) override;
  void note(const std::string& sentence) override;
  void began(const LineFormat& format, const CaptureContext& context) override;
  void progress(int lines_read, int lines_committed, int n_lines) override;

 private:
  Reporter& reporter_;
  ScanPage* page_;
  double bytes_per_line_ = 0;
};

// "1 frame · 4000 dpi · RGB+IR · 16 bit · 188.1 MB · to scans"
[[nodiscard]] std::string plan_line(const ScanPlan& plan, const std::string& place);
[[nodiscard]] double master_bytes(const LineFormat& format);
// "LS-5000 ED 1.03, holder …, USB"
[[nodiscard]] std::string device_line(const Capabilities& capabilities);
// "4000 dpi" as granted, and why.
[[nodiscard]] std::string adjustment_line(const Adjustment& adjustment);

}  // namespace reseau::cli
