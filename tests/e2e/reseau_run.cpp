#include "tests/e2e/reseau_run.h"

#include <algorithm>
#include <sstream>

#include <gtest/gtest.h>

namespace reseau::testing {

std::vector<std::string> command(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), RESEAU_BINARY);
  return arguments;
}

ProcessResult reseau(std::vector<std::string> arguments, const ProcessOptions& options) {
  ProcessResult result = run_process(command(std::move(arguments)), options);
  EXPECT_FALSE(result.timed_out) << result.err;
  EXPECT_EQ(result.signal, 0) << result.err;
  return result;
}

std::vector<nlohmann::json> json_lines(const std::string& text) {
  std::vector<nlohmann::json> list;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    auto json = nlohmann::json::parse(line, nullptr, false);
    EXPECT_FALSE(json.is_discarded()) << line;
    if (!json.is_discarded()) list.push_back(std::move(json));
  }
  return list;
}

std::vector<nlohmann::json> events_of(const std::vector<nlohmann::json>& lines,
                                      const std::string& event) {
  std::vector<nlohmann::json> list;
  std::copy_if(lines.begin(), lines.end(), std::back_inserter(list),
               [&](const nlohmann::json& line) { return line.value("event", "") == event; });
  return list;
}

std::filesystem::path only_file(const std::filesystem::path& folder, const std::string& ending) {
  std::vector<std::string> found;
  for (const std::string& name : names_in(folder)) {
    if (name.size() >= ending.size() &&
        name.compare(name.size() - ending.size(), ending.size(), ending) == 0) {
      found.push_back(name);
    }
  }
  EXPECT_EQ(found.size(), 1U) << ending << " in " << folder;
  return found.size() == 1 ? folder / found.front() : std::filesystem::path();
}

std::vector<std::string> small_scan(const std::string& verb_device, const std::string& output) {
  return {"scan", "-d", verb_device, "-x", "3mm", "-y", "2mm", "-o", output};
}

}  // namespace reseau::testing
