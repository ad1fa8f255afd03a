// Which calibration a scan is developed with.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "calibration/profile/profile.h"
#include "core/line/capture_context.h"
#include "core/line/corrected_lines.h"
#include "core/reconstruct/unit_sharpness.h"

namespace reseau {

// As a person chooses it.
struct ProfileChoice {
  bool look_for_it = true;       // among the calibrations that are kept, by model and serial number
  std::optional<Profile> given;  // this one instead
  std::filesystem::path path;    // of the given one
};

// "auto", "none" or a file, which is read. Throws InputError naming what is wrong with the file,
// std::system_error when it cannot be read.
[[nodiscard]] ProfileChoice parse_profile_choice(const std::string& word);

// For reconstruction and receipts.
struct UsedProfile {
  UnitSharpness unit;          // empty when there is none
  LevelCorrection levels;      // likewise: dark level, flat field
  std::filesystem::path path;  // empty when there is none
  std::string measured_at_utc;
  std::vector<std::string> notes;  // sentences: why none is used, or what to mind
};

// Throws InputError when a profile was given that is of another unit or resolution than the scan.
// One that was found and does not fit is left out, with the reason in the notes. `dpi` 0 = unknown.
[[nodiscard]] UsedProfile use_profile(const ProfileChoice& choice, const CaptureContext& context,
                                      double dpi);

}  // namespace reseau
