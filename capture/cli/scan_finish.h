// What comes after the last line: the picture of a broken scan, the receipt, the summary, the exit
// code.
#pragma once

#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>

#include "capture/cli/develop_choice.h"
#include "capture/cli/program.h"
#include "capture/session/develop.h"
#include "capture/session/scan_session.h"
#include "capture/store/master_writer.h"
#include "drivers/scan_plan.h"

namespace reseau::cli {

// All that is known of one scan.
struct ScanRecord {
  ScanRequest request;
  Negotiated negotiated;
  ScanOutcome outcome;
  MasterResult master;
  DevelopOptions settings;  // without paths
  PictureNames names;
  std::filesystem::path recording;
  bool want_picture = true;
  bool want_view = true;
  std::string quality;
  std::optional<Development> development;

  [[nodiscard]] DevelopOptions options_with_paths() const;
};

[[nodiscard]] ExitCode finish_scan(ScanRecord& record, const std::stop_token& stop, Work& work);

}  // namespace reseau::cli
