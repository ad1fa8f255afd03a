// `calibrate --reseau`: where the channels lie against each other, from the réseau of a film; and
// what the calibration says of it, wherever it comes from.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "calibration/profile/profile.h"
#include "capture/cli/calibrate_run.h"
#include "capture/cli/program.h"
#include "core/line/capture_context.h"
#include "core/reconstruct/reconstruct.h"

namespace reseau::cli {

struct ReseauOfFile {
  std::filesystem::path path;
  CaptureContext context;
  double dpi = 0;
  Registration registration;
  ChannelOffsets offsets;  // with reasons only where no réseau was found
  [[nodiscard]] bool measured() const;
};

// Nothing when it was stopped. Failures name the file.
[[nodiscard]] std::optional<ReseauOfFile> measure_reseau(const std::filesystem::path& path,
                                                         const MeasureChoice& choice, Work& work);

[[nodiscard]] nlohmann::ordered_json reseau_to_json(const ReseauOfFile& file);
[[nodiscard]] std::string describe(const ReseauOfFile& file);
// Offsets into the profile where it has none, or less sure ones.
void put_reseau(const ReseauOfFile& file, Profile& profile);

// Where the channels lie against green, as the profile has it.
void report_offsets(const Profile& profile, Reporter& reporter, nlohmann::ordered_json& result);

}  // namespace reseau::cli
