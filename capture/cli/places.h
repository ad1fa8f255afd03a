#pragma once

#include <filesystem>
#include <vector>

#include "drivers/registry.h"

namespace reseau::cli {

// Room and permission where scans will go, and the folder of calibrations. Changes nothing.
[[nodiscard]] std::vector<Finding> diagnose_places(const std::filesystem::path& output);

}  // namespace reseau::cli
