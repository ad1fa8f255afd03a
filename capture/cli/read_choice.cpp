#include "capture/cli/read_choice.h"

#include <fmt/format.h>

#include "capture/cli/failure.h"

namespace reseau::cli {

void ReadChoice::add_to(CLI::App& app) {
  app.add_option("FILE", file, "A scan: TIFF with red, green, blue and, if there is, infrared")
      ->required();
  app.add_option("--gamma", gamma, "Encoding gamma of the samples; overrides an embedded profile")
      ->group("Scan");
  app.add_option("--infrared-file", infrared_file,
                 "A TIFF with the infrared, instead of what is in or beside the scan")
      ->group("Scan");
}

Scan ReadChoice::read(Reporter& reporter) const {
  ReadScanOptions options;
  options.gamma = gamma;
  options.infrared_file = infrared_file;
  options.allow_grey = allow_grey;
  Scan scan = as_failure(Doing::kReadingInput, [&] { return read_scan(file, options); });
  for (const std::string& note : scan.notes) reporter.note(note);
  return scan;
}

std::string ReadChoice::tone_word(const Scan& scan) const {
  if (gamma) return fmt::format("gamma {}", *gamma);
  return scan.icc.empty() ? "linear" : "ICC profile";
}

}  // namespace reseau::cli
