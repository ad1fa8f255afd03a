// The built program, run by tests.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/support/process.h"
#include "tests/support/temp_dir.h"

namespace reseau::testing {

using test::file_bytes;
using test::names_in;
using test::TempDir;
using test::write_bytes;

// The program's path and arguments.
[[nodiscard]] std::vector<std::string> command(std::vector<std::string> arguments);
[[nodiscard]] ProcessResult reseau(std::vector<std::string> arguments,
                                   const ProcessOptions& options = {});

// Lines of stdout as JSON. A line that is none fails the test and is left out.
[[nodiscard]] std::vector<nlohmann::json> json_lines(const std::string& text);
// The events of that name.
[[nodiscard]] std::vector<nlohmann::json> events_of(const std::vector<nlohmann::json>& lines,
                                                    const std::string& event);

// The only file of the folder that ends so; fails the test and is empty when there is not one.
std::filesystem::path only_file(const std::filesystem::path& folder, const std::string& ending);

// A device whose film and options make a scan of a second.
inline const std::string kDevice = "sim:ls5000?seed=5";
[[nodiscard]] std::vector<std::string> small_scan(const std::string& verb_device,
                                                  const std::string& output);

}  // namespace reseau::testing
