// Two calibrations held against each other.
#pragma once

#include <filesystem>

#include <nlohmann/json.hpp>

#include "calibration/profile/profile.h"
#include "capture/cli/reporter.h"

namespace reseau::cli {

// Every figure that both hold, with the change and its deviation; "changed" beyond three of them.
// Lines for people, the object for programs.
[[nodiscard]] nlohmann::ordered_json compare_profiles(const Profile& now, const Profile& earlier,
                                                      Reporter& reporter);

// The calibration of this unit that is kept, against the new one, into result["compared_with"].
void compare_with_kept(const Profile& now, Reporter& reporter, nlohmann::ordered_json& result);

// Two files. Throws what load_profile throws.
[[nodiscard]] nlohmann::ordered_json compare_files(const std::filesystem::path& now,
                                                   const std::filesystem::path& earlier,
                                                   Reporter& reporter);

}  // namespace reseau::cli
