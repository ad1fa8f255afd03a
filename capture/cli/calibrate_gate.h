// The open frame: from files or the scanner into JSON, table, profile and report.
#pragma once

#include <filesystem>
#include <string>

#include <nlohmann/json.hpp>

#include "calibration/gate/gate.h"
#include "calibration/profile/profile.h"
#include "capture/cli/reporter.h"
#include "capture/image/scan_reader.h"

namespace reseau::cli {

// Lines of the middle of a file, at most 256. `context` gets what the file says of the unit.
[[nodiscard]] GateScan read_gate(const std::filesystem::path& path, const ReadScanOptions& read,
                                 CaptureContext& context, double& dpi, Reporter& reporter);

void put_gate(const GateResult& gate, Profile& profile);
[[nodiscard]] nlohmann::ordered_json gate_to_json(const GateResult& gate);
[[nodiscard]] std::string describe(const GateResult& gate);
[[nodiscard]] std::string gate_html(const GateResult& gate);

}  // namespace reseau::cli
