// Profiles as JSON files: `{"schema": "reseau.profile/1", …}`, doubles exact in a round trip.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/profile/profile.h"

namespace reseau {

[[nodiscard]] std::string profile_to_json(const Profile& profile);
// `source` names the text in messages. Throws InputError naming source and field.
[[nodiscard]] Profile profile_from_json(std::string_view text, const std::string& source);

// Throws InputError, or std::system_error when the file cannot be read.
[[nodiscard]] Profile load_profile(const std::filesystem::path& path);
// Writes beside, then renames, replacing an older file of that name; makes the folder. Throws
// std::system_error; InputError from validate().
void save_profile(const Profile& profile, const std::filesystem::path& path);

// $XDG_DATA_HOME/reseau/calibrations, ~/.local/share/… when unset.
[[nodiscard]] std::filesystem::path default_profile_directory();
// `<model>-<serial>/<date>-<dpi>dpi.json` below `directory`, in characters safe for any file
// system.
[[nodiscard]] std::filesystem::path profile_path(const std::filesystem::path& directory,
                                                 const Profile& profile);

struct FoundProfile {
  std::filesystem::path path;
  Profile profile;
};
struct ProfileSearch {
  std::optional<FoundProfile> found;
  std::vector<std::string> problems;  // files that could not be read, as sentences
};

// The newest profile of this unit below `directory`; one measured at `dpi` comes before others (0 =
// any). Model and serial must be equal, the serial may be empty on both sides. A missing folder is
// no problem.
[[nodiscard]] ProfileSearch find_profile(const std::filesystem::path& directory,
                                         const std::string& model, const std::string& serial,
                                         double dpi = 0);

}  // namespace reseau
