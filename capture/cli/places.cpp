#include "capture/cli/places.h"

#include <cerrno>
#include <cmath>
#include <system_error>

#include <fmt/format.h>
#include <unistd.h>

#include "calibration/profile/profile_io.h"
#include "capture/cli/reporter.h"

namespace reseau::cli {

namespace {

using Level = Finding::Level;

// The master of one frame of 24 megapixels, RGB and infrared, 16 bit.
constexpr double kBytesPerFrame = 188.1e6;

// The folder itself, or the nearest one above it that exists.
std::filesystem::path existing_part(std::filesystem::path path) {
  std::error_code ignored;
  path = std::filesystem::absolute(path, ignored).lexically_normal();
  while (!std::filesystem::exists(path, ignored) && path.has_relative_path()) {
    path = path.parent_path();
  }
  return path;
}

Finding writable(const std::filesystem::path& folder, const std::string& what,
                 const std::string& elsewhere) {
  const std::filesystem::path there = existing_part(folder);
  std::error_code ignored;
  if (!std::filesystem::is_directory(there, ignored)) {
    return {Level::kProblem, what, there.string() + " is no folder", elsewhere};
  }
  if (::access(there.c_str(), W_OK | X_OK) != 0) {
    return {Level::kProblem, what,
            fmt::format("{} cannot be written: {}", there.string(),
                        std::generic_category().message(errno)),
            elsewhere};
  }
  return {Level::kOk, what,
          there == existing_part(folder) && std::filesystem::exists(folder, ignored)
              ? folder.string() + " can be written"
              : fmt::format("{} will be made in {}", folder.string(), there.string()),
          ""};
}

Finding room(const std::filesystem::path& folder) {
  const std::string what = "room for scans";
  std::error_code problem;
  const auto space = std::filesystem::space(existing_part(folder), problem);
  if (problem) {
    return {Level::kWarning, what, "the free space cannot be asked for: " + problem.message(), ""};
  }
  const auto available = static_cast<double>(space.available);
  const std::string detail =
      fmt::format("{} free, enough for {:.0f} frames at 4000 dpi", human_bytes(available),
                  std::floor(available / kBytesPerFrame));
  // A frame needs its master, its reconstruction in floats and the copies to look at.
  if (available < 5 * kBytesPerFrame) {
    return {Level::kProblem, what, detail, "free some space, or choose another folder with -o"};
  }
  return {Level::kOk, what, detail, ""};
}

}  // namespace

std::vector<Finding> diagnose_places(const std::filesystem::path& output) {
  std::vector<Finding> findings{
      writable(output, "folder for scans", "choose another folder with -o"), room(output)};
  Finding calibrations = writable(default_profile_directory(), "folder for calibrations",
                                  "set XDG_DATA_HOME to a folder that you may write to");
  // Scanning works without.
  if (calibrations.level == Level::kProblem) calibrations.level = Level::kWarning;
  findings.push_back(calibrations);
  return findings;
}

}  // namespace reseau::cli
