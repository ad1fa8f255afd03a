// Options of every verb that reads a scan, and how a scan is described.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include <CLI/App.hpp>

#include "capture/cli/reporter.h"
#include "capture/image/scan_reader.h"

namespace reseau::cli {

struct ReadChoice {
  std::string file;
  std::optional<double> gamma;
  std::string infrared_file;
  bool allow_grey = false;  // set by the verb: one channel is enough

  void add_to(CLI::App& app);
  // Reads; notes go to the reporter. Every failure is a Failure kExitInput or kExitNoMemory.
  [[nodiscard]] Scan read(Reporter& reporter) const;
  // "gamma 2.2", "ICC profile" or "linear": for receipts.
  [[nodiscard]] std::string tone_word(const Scan& scan) const;
};

}  // namespace reseau::cli
