// Scans of the calibration at the bench: to a file, and to memory.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/cli/program.h"
#include "core/line/capture_context.h"
#include "drivers/scan_plan.h"
#include "drivers/scanner.h"

namespace reseau::cli {

// One small scan: planes of red, green, blue, infrared [line][pixel], 0 to 1.
struct BenchScan {
  int width_px = 0, n_lines = 0, sensor_lines = 0;
  CaptureContext context;
  std::array<std::vector<float>, 4> light;  // empty = not scanned
};

// A device with `target` ("razor", "clear") in it: a simulated unit gets it laid in, where its name
// does not say what lies in it; with a real one a person has done so.
[[nodiscard]] std::string device_with(const std::string& name, const std::string& target,
                                      bool replace);

// False when it was stopped. Throws what the scanner, the disk or a driver's protocol throw.
[[nodiscard]] bool scan_to_file(Scanner& scanner, const ScanPlan& plan,
                                const std::string& device_name, const std::filesystem::path& path,
                                Work& work);
[[nodiscard]] std::optional<BenchScan> scan_to_memory(Scanner& scanner, const ScanPlan& plan,
                                                      Work& work);

// Says `sentence` and waits for Enter, unless `yes`. False when stopped. Failure when nobody can
// answer.
[[nodiscard]] bool ask(const std::string& sentence, bool yes, Work& work);

}  // namespace reseau::cli
